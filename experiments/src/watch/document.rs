//! Documents as a page gets them.

use std::fmt::Write;
use std::sync::Arc;

use csat_mission::documents::OWN;
use serde::Deserialize;

/// The largest document, bytes.
pub const MAX_BYTES: usize = 32 << 20;

/// A document of `docs/topics.md`.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// Its topic below `csat/{run}/`, such as `view/0/pose`.
    pub topic: String,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// JSON, in one line.
    pub body: Arc<str>,
}

/// Whether a line of text may stand in the middle of other JSON, and its `time_s`.
#[derive(Deserialize)]
struct Stamp {
    #[serde(default)]
    time_s: Option<f64>,
}

impl Document {
    /// A document of the bytes of another process; `time_s` is that of its body, 0 without.
    ///
    /// # Errors
    /// What is wrong with it: a body must be one JSON object of at most [`MAX_BYTES`].
    pub fn parse(topic: impl Into<String>, bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() > MAX_BYTES {
            return Err(format!("got {} bytes, expected at most {MAX_BYTES}", bytes.len()));
        }
        let text = std::str::from_utf8(bytes).map_err(|e| e.to_string())?;
        if !text.trim_start().starts_with('{') {
            let start: String = text.chars().take(20).collect();
            return Err(format!("got `{start}`, expected an object"));
        }
        let Stamp { time_s } = serde_json::from_str(text).map_err(|e| e.to_string())?;
        // Within JSON a line may only end between tokens, so that a space does as well.
        let body = text.replace(['\n', '\r'], " ").into();
        Ok(Self { topic: topic.into(), time_s: time_s.unwrap_or(0.0), body })
    }

    /// The agent and what of it, when this is what an agent knows.
    pub fn agent(&self) -> Option<(usize, &str)> {
        view_of(&self.topic)
    }
}

/// The agent and the last part of `view/{i}/{name}`.
fn view_of(topic: &str) -> Option<(usize, &str)> {
    let (agent, name) = topic.strip_prefix("view/")?.split_once('/')?;
    Some((agent.parse().ok()?, name))
}

/// Whether a page that draws what `agent` knows needs a topic: the layers of the others, nearly all of
/// the bytes, are not drawn.
pub fn is_drawn(topic: &str, agent: usize) -> bool {
    view_of(topic).is_none_or(|(of, name)| of == agent || OWN.contains(&name))
}

/// Documents as JSON: an object by topic.
pub fn by_topic<'a>(documents: impl IntoIterator<Item = &'a Document>) -> String {
    let mut json = String::from("{");
    for Document { topic, body, .. } in documents {
        let comma = if json.len() == 1 { "" } else { "," };
        let topic = serde_json::Value::from(topic.as_str());
        write!(json, "{comma}{topic}:{body}").expect("text grows");
    }
    json + "}"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_agents_that_are_not_drawn_stay_here() {
        for topic in ["view/1/pose", "view/1/links", "view/0/oem", "truth/town", "view/x/oem"] {
            assert!(is_drawn(topic, 0), "{topic}");
        }
        for topic in ["view/1/oem", "view/10/targets", "view/1/hidden"] {
            assert!(!is_drawn(topic, 0), "{topic}");
        }
    }

    #[test]
    fn bad_documents_are_refused_with_the_reason() {
        let long = vec![b' '; MAX_BYTES + 1];
        let cases: [(&[u8], &str); 5] = [
            (b"\xFF", "invalid utf-8"),
            (b"[1]", "got `[1]`, expected an object"),
            (b"{\"time_s\":1", "EOF"),
            (b"{\"time_s\":\"x\"}", "invalid type"),
            (&long, "expected at most"),
        ];
        for (bytes, expected) in cases {
            let error = Document::parse("view/0/pose", bytes).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        let folded = Document::parse("a", b"{\r\n\"time_s\": 2}").unwrap();
        assert_eq!((&*folded.body, folded.time_s), ("{  \"time_s\": 2}", 2.0));
    }
}
