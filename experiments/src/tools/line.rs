//! A sample as a line of text or of JSON.

use csat_proto::control::FrameHeader;
use csat_proto::envelope::Envelope;
use csat_proto::keys::{split, split_agent};
use csat_proto::message::Message;
use serde_json::{Map, Value, json};

use super::ear::Heard;
use csat_mission::words::counted;

/// How many characters of a document are shown on a line.
const MAX_SHOWN: usize = 160;

/// A line of text: key, bytes and what is said, shortened.
pub fn text(heard: &Heard) -> String {
    let Heard { key, bytes, .. } = heard;
    let line = match said(heard) {
        _ if heard.is_gone => format!("{key} deleted"),
        Said::Nothing => format!("{key} {bytes} B"),
        Said::Text(text) => format!("{key} {bytes} B {}", cut(&text)),
        Said::Message(message) => {
            format!("{key} {bytes} B {}", describe(&message.0, message.1.as_ref()))
        }
        Said::Header(header) => format!("{key} {bytes} B {}", cut(&describe_header(&header))),
    };
    // What strangers publish must not steer the terminal.
    line.replace(char::is_control, " ")
}

/// A line about a token.
pub fn token_text(heard: &Heard) -> String {
    let happens = if heard.is_gone { "is gone" } else { "is alive" };
    format!("{} {happens}", heard.key).replace(char::is_control, " ")
}

/// A token as JSON.
pub fn token_json(heard: &Heard) -> Value {
    json!({ "key": heard.key, "alive": !heard.is_gone })
}

/// All of it as JSON: `key`, `encoding`, `bytes`, `body` if it is text, JSON or a message of the
/// links, and `attachment` if there is one.
pub fn json(heard: &Heard) -> Value {
    let mut object = Map::new();
    object.insert("key".into(), heard.key.clone().into());
    if heard.is_gone {
        object.insert("deleted".into(), true.into());
        return object.into();
    }
    object.insert("encoding".into(), heard.encoding.clone().into());
    object.insert("bytes".into(), heard.bytes.into());
    match said(heard) {
        Said::Text(text) => {
            object.insert("body".into(), parsed(text));
        }
        Said::Message(message) => {
            object.insert("body".into(), message_json(&message.0, message.1.as_ref()));
        }
        Said::Nothing | Said::Header(_) => {}
    }
    if let Some(attachment) = heard.attachment.as_deref().and_then(readable) {
        object.insert("attachment".into(), parsed(attachment));
    }
    object.into()
}

/// What a sample says.
enum Said {
    /// Nothing that can be read.
    Nothing,
    /// Text, mostly JSON.
    Text(String),
    /// A message of the links, and its body if it is one of the set-membership mission.
    Message(Box<(Envelope, Option<Message>)>),
    /// Something binary, and text beside it: a frame.
    Header(String),
}

fn said(heard: &Heard) -> Said {
    let name = split(&heard.key).map(|(_, name)| name);
    if name.and_then(|name| split_agent(name, "link")).is_some()
        && let Ok(envelope) = Envelope::decode(&heard.body)
    {
        let message = postcard::from_bytes(&envelope.body).ok();
        return Said::Message(Box::new((envelope, message)));
    }
    if let Some(text) = readable(&heard.body).filter(|text| !text.is_empty()) {
        return Said::Text(text);
    }
    heard.attachment.as_deref().and_then(readable).map_or(Said::Nothing, Said::Header)
}

/// Text, if it is that.
fn readable(bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    let is_text = text.chars().all(|c| !c.is_control() || c.is_whitespace());
    is_text.then(|| text.to_owned())
}

/// JSON as it is meant, anything else as a string.
fn parsed(text: String) -> Value {
    serde_json::from_str(&text).unwrap_or(Value::String(text))
}

fn cut(text: &str) -> String {
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

fn kind(message: Option<&Message>) -> &'static str {
    match message {
        Some(Message::Fact(_)) => "fact",
        Some(Message::Snapshot(_)) => "snapshot",
        Some(Message::Plan(_)) => "plan",
        Some(Message::Relay(_)) => "relay",
        None => "unknown",
    }
}

fn describe(envelope: &Envelope, message: Option<&Message>) -> String {
    let Envelope { src, incarnation, channel, sequence, step, time, .. } = envelope;
    let about = match message {
        Some(Message::Fact(fact)) => format!(
            " number {} of step {}, {}",
            fact.number,
            fact.step,
            counted(fact.targets.len(), "target")
        ),
        Some(Message::Snapshot(snapshot)) => format!(
            " of step {}, {} known",
            snapshot.fact.step,
            counted(snapshot.known.targets.len(), "target")
        ),
        Some(Message::Plan(plan)) => format!(
            " of step {}, pass {}, {}",
            plan.step,
            plan.pass,
            counted(plan.poses.len(), "pose")
        ),
        Some(Message::Relay(relay)) => {
            format!(" of step {}, {}", relay.step, counted(relay.plans.len(), "plan"))
        }
        None => format!(", {} B", envelope.body.len()),
    };
    format!(
        "agent {src} life {incarnation} radio {channel} message {sequence} step {step} {} s: {}{about}",
        time.seconds(),
        kind(message)
    )
}

/// A frame's header, or whatever else goes beside bytes.
fn describe_header(header: &str) -> String {
    let Ok(FrameHeader { step, time, pose, incarnation, detections, .. }) =
        serde_json::from_str(header)
    else {
        return format!("with {header}");
    };
    let seen = match incarnation {
        Some(life) => format!("life {life}, {} identified", counted(detections.len(), "target")),
        None => "down".to_owned(),
    };
    let ([x, y, z], seconds) = (pose.p_world, time.seconds());
    format!("frame of step {step} {seconds} s at [{x:.1}, {y:.1}, {z:.1}]: {seen}")
}

fn message_json(envelope: &Envelope, message: Option<&Message>) -> Value {
    json!({
        "run": envelope.run,
        "src": envelope.src,
        "incarnation": envelope.incarnation,
        "channel": envelope.channel,
        "sequence": envelope.sequence,
        "step": envelope.step,
        "time_s": envelope.time.seconds(),
        "pose": envelope.pose,
        "kind": kind(message),
        "message_bytes": envelope.body.len(),
        "message": message,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::camera::Pose;
    use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
    use csat_proto::message::Plan;
    use csat_proto::time::{SimTime, Step};

    fn heard(key: &str, body: &[u8]) -> Heard {
        let (key, encoding) = (key.to_owned(), "application/json".to_owned());
        Heard { key, encoding, bytes: body.len(), body: body.to_vec(), ..Heard::default() }
    }

    fn message(body: Vec<u8>) -> Vec<u8> {
        let envelope = Envelope {
            run: RunId(1),
            src: AgentId(2),
            incarnation: Incarnation(1),
            channel: ChannelId(0),
            sequence: 99,
            step: Step(12),
            time: SimTime::from_seconds(6.0),
            pose: Pose::level([1.0, 2.0, 52.0], 0.3).into(),
            body,
        };
        envelope.encode()
    }

    fn plan() -> Vec<u8> {
        let poses = vec![Pose::level([1.0, 2.0, 52.0], 0.3).into()];
        postcard::to_stdvec(&Message::Plan(Plan { step: Step(12), pass: 1, poses })).unwrap()
    }

    #[test]
    fn documents_are_shown_as_they_are_up_to_a_limit() {
        let clock = heard("csat/1/clock", b"{\"b\":1,\n\"a\":2}");
        assert_eq!(text(&clock), "csat/1/clock 14 B {\"b\":1, \"a\":2}");
        assert_eq!(
            json(&clock).to_string(),
            r#"{"body":{"a":2,"b":1},"bytes":14,"encoding":"application/json","key":"csat/1/clock"}"#
        );
        let long = heard("k", "é".repeat(200).as_bytes());
        assert_eq!(text(&long), format!("k 400 B {}…", "é".repeat(MAX_SHOWN)));
        assert_eq!(json(&long)["body"], "é".repeat(200));
    }

    #[test]
    fn messages_of_the_links_are_decoded() {
        let bytes = message(plan());
        let plan = heard("csat/1/link/2/0", &bytes);
        assert_eq!(
            text(&plan),
            format!(
                "csat/1/link/2/0 {} B agent 2 life 1 radio 0 message 99 step 12 6 s: plan of step 12, \
                 pass 1, 1 pose",
                bytes.len()
            )
        );
        let body = &json(&plan)["body"];
        assert_eq!(
            (&body["src"], &body["kind"], &body["time_s"]),
            (&2.into(), &"plan".into(), &6.0.into())
        );
        assert_eq!(body["message"]["Plan"]["pass"], 1);
        let other = heard("csat/1/link/2/0", &message(vec![200; 3]));
        assert!(text(&other).ends_with("6 s: unknown, 3 B"), "{}", text(&other));
        // The same bytes elsewhere, and damaged ones, are just bytes.
        assert_eq!(
            text(&heard("csat/1/uav/2/report", &bytes)),
            format!("csat/1/uav/2/report {} B", bytes.len())
        );
        let cut = heard("csat/1/link/2/0", &bytes[..9]);
        assert_eq!(text(&cut), "csat/1/link/2/0 9 B");
        assert_eq!(json(&cut).get("body"), None);
    }

    #[test]
    fn frames_are_shown_by_their_header() {
        let frame = |header: &str| Heard {
            attachment: Some(header.as_bytes().to_vec()),
            ..heard("csat/1/uav/0/frame", &[0; 50])
        };
        let mut header = FrameHeader {
            world: 5,
            step: Step(3),
            time: SimTime::from_seconds(1.5),
            next: SimTime::from_seconds(2.0),
            pose: Pose::level([1.0, 2.04, 52.0], 0.3),
            pose_error: csat_proto::camera::PoseError::NONE,
            p_world: None,
            yaw_rad: None,
            incarnation: Some(Incarnation(1)),
            detections: Vec::new(),
            sighting: None,
            said: Vec::new(),
        };
        let alive = frame(&serde_json::to_string(&header).unwrap());
        let beginning = "csat/1/uav/0/frame 50 B frame of step 3 1.5 s at [1.0, 2.0, 52.0]: ";
        assert_eq!(text(&alive), format!("{beginning}life 1, 0 targets identified"));
        header.incarnation = None;
        let down = frame(&serde_json::to_string(&header).unwrap());
        assert_eq!(text(&down), format!("{beginning}down"));
        let other = frame("{\"step\":3}");
        assert_eq!(text(&other), "csat/1/uav/0/frame 50 B with {\"step\":3}");
        assert_eq!(json(&alive)["attachment"]["step"], 3);
        assert_eq!(json(&alive).get("body"), None);
    }

    #[test]
    fn what_strangers_say_does_not_steer_the_terminal() {
        assert_eq!(text(&heard("csat/1/x", b"\x1b[2J")), "csat/1/x 4 B");
        assert_eq!(text(&heard("csat/1/\x1bx", b"a\tb")), "csat/1/ x 3 B a b");
    }

    #[test]
    fn tokens_come_and_go() {
        let mut token = heard("csat/1/alive/0", b"");
        assert_eq!(token_text(&token), "csat/1/alive/0 is alive");
        token.is_gone = true;
        assert_eq!(token_text(&token), "csat/1/alive/0 is gone");
        assert_eq!(token_json(&token), json!({"key": "csat/1/alive/0", "alive": false}));
        assert_eq!(text(&token), "csat/1/alive/0 deleted");
        assert_eq!(json(&token), json!({"key": "csat/1/alive/0", "deleted": true}));
    }
}
