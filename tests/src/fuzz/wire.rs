//! Input from the wire besides messages: frames, control, and the queue of messages.

use std::collections::BTreeSet;

use csat_experiments::set_membership::report::Report;
use csat_peer::fuzzing::{MessageQueue, RawMessage, StepReport};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::control::{
    Announcement, Done, FrameHeader, Join, Order, Probe, Ready, SaidSoFar, Welcome,
};
use csat_proto::envelope::Envelope;
use csat_proto::frame_wire;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::radio::PhysicalHeader;
use csat_proto::time::{SimTime, Step};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Between the header of a frame and its pixels.
const SEPARATOR: u8 = 0;

/// A camera with few pixels.
fn camera() -> CameraModel {
    CameraModel { columns: 8, rows: 4, ..CameraModel::default() }
}

/// A frame: its header, a zero byte, its pixels.
///
/// # Panics
/// When a property does not hold.
pub fn frame(bytes: &[u8]) {
    let end = bytes.iter().position(|byte| *byte == SEPARATOR).unwrap_or(bytes.len());
    let (header, pixels) = (&bytes[..end], bytes.get(end + 1..).unwrap_or_default());
    let camera = camera();
    let image = frame_wire::decode(pixels, camera.pixels());
    if let Ok((labels, depth)) = &image {
        assert_eq!((labels.len(), depth.len()), (camera.pixels(), camera.pixels()));
        let again = frame_wire::decode(&frame_wire::encode(labels, depth), camera.pixels());
        assert_eq!(again.as_ref(), Ok(&(labels.clone(), depth.clone())), "pixels change");
    }
    let Some(header) = json::<FrameHeader>(header) else { return };
    let _ = header.check_blind(0.5, pixels.len());
    let Ok((labels, _)) = image else { return };
    if header.check(&camera, 0.5, &labels).is_ok() {
        let p_world = header.p_world.unwrap_or(header.pose.p_world);
        assert!(PhysicalHeader { p_world }.is_place(), "{header:?}");
    }
}

/// Messages of the protocol between the world and the processes of agents.
///
/// # Panics
/// When a property does not hold.
pub fn control(bytes: &[u8]) {
    json::<Join>(bytes);
    json::<Welcome>(bytes);
    json::<Ready>(bytes);
    json::<Probe>(bytes);
    json::<PhysicalHeader>(bytes);
    if let Some(done) = json::<Done>(bytes) {
        let _ = done.said.is_none_or(|said| said.is_possible(done.step));
    }
    if let Some(Announcement { order: Order::Turn { step, said, .. }, .. }) = json(bytes) {
        let _ = said.iter().all(|said| said.is_possible(step));
    }
    if let Ok(report) = StepReport::<Report>::decode(bytes) {
        let again = report.encode();
        let twice = StepReport::<Report>::decode(&again).expect("what it says itself").encode();
        assert_eq!(again, twice, "a report changes");
    }
}

/// The value of a JSON text, if it has one; its own JSON has the same value.
fn json<T: Serialize + DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let value: T = serde_json::from_slice(bytes).ok()?;
    let text = serde_json::to_string(&value).ok()?;
    // A float without JSON becomes null, and is refused.
    if let Ok(again) = serde_json::from_str::<T>(&text) {
        assert_eq!(
            serde_json::to_string(&again).ok().as_deref(),
            Some(text.as_str()),
            "it changes"
        );
    }
    Some(value)
}

/// Messages and orders in any sequence, six bytes each: kind, agent, incarnation, radio, and a number
/// of two bytes.
///
/// # Panics
/// When a property does not hold.
pub fn queue(bytes: &[u8]) {
    let own = AgentId(0);
    let (mut queue, mut heard) = (MessageQueue::default(), BTreeSet::new());
    for &[what, agent, life, radio, high, low] in bytes.as_chunks::<6>().0 {
        let (agent, incarnation) = (AgentId(u16::from(agent % 4)), Incarnation((life % 3).into()));
        let (channel, number) = (ChannelId(radio % 2), u64::from(u16::from_be_bytes([high, low])));
        let said = SaidSoFar { agent, incarnation, next: vec![number; usize::from(radio % 3)] };
        let got = match what % 6 {
            0 => {
                queue.skip(&[said], SimTime(number));
                Vec::new()
            }
            1 if queue.first_missing(std::slice::from_ref(&said), own).is_none() => {
                let got = queue.take(std::slice::from_ref(&said), own);
                let is_announced = |one: &csat_mission::node::Said| {
                    let next = said.next.get(usize::from(one.channel.0));
                    one.src == agent && next.is_some_and(|next| one.sequence < *next)
                };
                assert!(got.iter().all(is_announced), "heard without a word: {got:?}");
                got
            }
            2 => queue.take_all(),
            _ => {
                let sequence = if what & 0x80 == 0 { number } else { u64::MAX - number };
                let bytes = message(agent, incarnation, channel, sequence);
                let newest = (what & 0x40 == 0).then_some(Step(0));
                let physical = (what & 0x20 == 0).then_some(PhysicalHeader { p_world: [0.0; 3] });
                let key = AgentId(u16::from(life % 5));
                let _ = queue.push(RawMessage { key, physical, bytes }, newest);
                Vec::new()
            }
        };
        for said in got {
            let name = (said.src, said.incarnation, said.channel, said.sequence);
            assert!(heard.insert(name), "{name:?} is heard twice");
        }
    }
}

fn message(src: AgentId, incarnation: Incarnation, channel: ChannelId, sequence: u64) -> Vec<u8> {
    let pose = Pose::level([0.0, 0.0, 50.0], 0.0).into();
    let (run, step, time) = (RunId(1), Step(20), SimTime(10_000_000));
    let body = Vec::new();
    Envelope { run, src, incarnation, channel, sequence, step, time, pose, body }.encode()
}

/// Valid inputs, by target and name.
pub fn seeds() -> Vec<(&'static str, String, Vec<u8>)> {
    let header = r#"{"world": 7, "step": 1, "time": 500000, "next": 1000000, "pose": {"p_world":
        [1.5, 2.5, 52.0], "yaw_rad": 0.2, "pitch_rad": 0.0, "roll_rad": 0.0}, "incarnation": 0,
        "detections": [{"target": 0, "pixels": {"columns": [1, 2], "rows": [0, 1]}}], "said":
        [{"agent": 0, "incarnation": 0, "next": [2]}]}"#;
    let truly = header.replace("\"incarnation\": 0, ", "\"incarnation\": null, ").replacen(
        "\"pose\"",
        "\"p_world\": [1.0, 2.0, 52.0], \"pose\"",
        1,
    );
    use csat_proto::frame::Label::{Ground, Obstacle, Target, Unknown};
    let labels = [Ground, Target, Target, Obstacle, Ground, Unknown, Unknown, Ground].repeat(4);
    let pixels = frame_wire::encode(&labels, &[300; 32]);
    let seen = [header.as_bytes(), &[SEPARATOR], &pixels].concat();
    let blind = [truly.as_bytes(), &[SEPARATOR]].concat();
    let mut seeds = vec![
        ("frame", "seen".to_owned(), seen),
        ("frame", "blind".to_owned(), blind),
        ("frame", "pixels".to_owned(), [&[SEPARATOR], &pixels[..]].concat()),
        ("frame", "header".to_owned(), header.as_bytes().to_vec()),
    ];
    for (name, text) in [
        ("join", r#"{"protocol":3,"program":"csat","agent":1,"process":42}"#),
        ("ready", r#"{"process":42,"heard":[[1,43]]}"#),
        ("probe", r#"{"process":42,"answer":true}"#),
        ("place", r#"{"p_world":[1.5,-2.0,52.0]}"#),
        (
            "turn",
            r#"{"world":7,"order":"turn","step":1,"round":1,"now":500000,
            "said":[{"agent":0,"incarnation":0,"next":[2]}]}"#,
        ),
        ("close", r#"{"world":7,"order":"close","step":1,"full":true}"#),
        ("end", r#"{"world":7,"order":"end","reason":"over"}"#),
        ("done", r#"{"process":42,"step":1,"round":0,"said":null,"due":500000,"commands":[]}"#),
        (
            "welcome",
            r#"{"protocol":3,"run":1,"world":7,"name":"city","scenario":"","map":null,
            "pace":{"realtime":2.0}}"#,
        ),
    ] {
        seeds.push(("control", name.to_owned(), text.as_bytes().to_vec()));
    }
    let steps: [(&str, &[[u8; 6]]); 4] = [
        ("in-order", &[[3, 1, 1, 0, 0, 0], [3, 1, 1, 0, 0, 1], [1, 1, 1, 1, 0, 2]]),
        ("late", &[[3, 1, 1, 0, 0, 5], [0, 1, 1, 1, 0, 4], [2, 0, 0, 0, 0, 0]]),
        ("twice", &[[3, 2, 2, 1, 1, 0], [3, 2, 2, 1, 1, 0], [2, 0, 0, 0, 0, 0]]),
        ("forged", &[[0x83, 3, 1, 0, 0, 0], [0x23, 1, 1, 0, 0, 0], [2, 0, 0, 0, 0, 0]]),
    ];
    for (name, steps) in steps {
        seeds.push(("queue", name.to_owned(), steps.concat()));
    }
    seeds
}
