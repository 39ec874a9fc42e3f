//! The key expression that a user means, and the keys that there are.

use zenoh::key_expr::KeyExpr;

use crate::bayes::Bayes;
use crate::set_membership::SetMembership;
use csat_mission::documents::names;
use csat_peer::wire::session::first_line;

/// What is shown of a run unless told otherwise: everything, of every run.
pub const ALL: &str = "csat/**";

/// How alike two keys are that one may be mistaken for, from 0 to 1.
const ALIKE: f64 = 0.6;

/// What is no key expression.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{keys}` is no key expression: {reason}\n  = expected such as `view/0/targets`, `view/*/pose`, \
     `link/**` or `csat/7/clock`; `*` is one whole part between slashes, `**` any number of them, \
     `a$*` a part that begins with a"
)]
pub struct BadKey {
    /// As it would have been subscribed to.
    pub keys: String,
    /// What Zenoh says.
    pub reason: String,
}

/// The key expression that a user means: what does not begin with `csat/` is below `csat/*/`.
///
/// # Errors
/// When it is none.
pub fn key_expression(given: Option<&str>) -> Result<KeyExpr<'static>, BadKey> {
    let given = given.unwrap_or(ALL);
    let keys =
        if given.starts_with("csat/") { given.to_owned() } else { format!("csat/*/{given}") };
    KeyExpr::autocanonize(keys.clone()).map_err(|error| {
        let line = first_line(&error.to_string());
        // Zenoh names the expression once more.
        let reason = line.split_once("`: ").map_or(line.as_str(), |(_, reason)| reason).to_owned();
        BadKey { keys, reason }
    })
}

/// When something comes on a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// As long as a mission flies.
    Flying,
    /// Now and then: when.
    Rarely(&'static str),
    /// To those who ask.
    Asked,
    /// Never: it is a liveliness token.
    Token,
}

/// Everything that a run has, below `csat/*/`, but for the documents of agents.
const TOPICS: [(&str, When); 15] = [
    ("clock", When::Flying),
    ("link/*/*", When::Flying),
    ("link/*/probe", When::Rarely("before an agent flies")),
    ("uav/*/frame", When::Flying),
    ("uav/*/command", When::Flying),
    ("uav/*/report", When::Flying),
    ("uav/*/ready", When::Rarely("before an agent flies")),
    ("truth/targets", When::Flying),
    ("truth/metrics", When::Flying),
    ("truth/town", ONCE),
    ("truth/layers", ONCE),
    ("truth/lives", When::Rarely("when an agent begins or ends")),
    ("join/*", When::Asked),
    ("state/*/*", When::Asked),
    ("alive/*", When::Token),
];

/// Of what is said once.
const ONCE: When = When::Rarely("at the start, and to those who ask (a Zenoh `get`)");

/// Everything that a run has, below `csat/*/`.
fn topics() -> impl Iterator<Item = (String, When)> {
    let names = names::<SetMembership>().chain(names::<Bayes>());
    let of_agents = names.map(|name| (format!("view/*/{name}"), When::Flying));
    TOPICS.iter().map(|(topic, when)| ((*topic).to_owned(), *when)).chain(of_agents)
}

/// When something comes on the keys of an expression; `None` if a run has no such key. Of several
/// topics the one that is heard most counts.
pub fn when(keys: &KeyExpr<'_>) -> Option<When> {
    let found = topics().filter(|(topic, _)| intersects(keys, &format!("csat/*/{topic}")));
    let rank = |when: &When| match when {
        When::Flying => 0,
        When::Rarely(_) => 1,
        When::Asked => 2,
        When::Token => 3,
    };
    // `link/*/*` is the only topic that covers another one: the narrower one is meant by its name.
    let is_probe = keys.ends_with("/probe");
    found.map(|(_, when)| when).filter(|w| !is_probe || *w != When::Flying).min_by_key(rank)
}

/// Whether some key is in both.
pub fn intersects(keys: &KeyExpr<'_>, other: &str) -> bool {
    KeyExpr::new(other).is_ok_and(|other| keys.intersects(&other))
}

/// The key that is most like an expression, among those heard and, failing that and if `known`, all
/// that there are.
pub fn nearest<'a>(
    keys: &str,
    heard: impl Iterator<Item = &'a str>,
    known: bool,
) -> Option<String> {
    let best = |all: &mut dyn Iterator<Item = String>| {
        all.map(|key| (strsim::normalized_levenshtein(keys, &key), key))
            .filter(|(likeness, _)| *likeness >= ALIKE)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, key)| key)
    };
    let topics = topics().filter(|_| known).map(|(topic, _)| format!("csat/*/{topic}"));
    best(&mut heard.map(ToOwned::to_owned)).or_else(|| best(&mut { topics }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full(given: &str) -> String {
        key_expression(Some(given)).unwrap().to_string()
    }

    #[test]
    fn short_keys_are_below_every_run() {
        assert_eq!(key_expression(None).unwrap().as_str(), "csat/**");
        for (given, expected) in [
            ("clock", "csat/*/clock"),
            ("view/0/targets", "csat/*/view/0/targets"),
            ("link/**", "csat/*/link/**"),
            ("**", "csat/*/**"),
            ("**/**/pose", "csat/*/**/pose"),
            ("csat/7/clock", "csat/7/clock"),
            ("csat/**", "csat/**"),
        ] {
            assert_eq!(full(given), expected);
        }
    }

    #[test]
    fn what_is_no_key_expression_says_why_and_what_is() {
        for (given, reason) in [
            ("view/a*", "`*` may only be preceded by `/` or `$`"),
            ("/clock", "empty chunks are forbidden"),
            ("clock/", "empty chunks are forbidden"),
            ("", "empty chunks are forbidden"),
            ("clock?", "`#` and `?` are forbidden"),
        ] {
            let error = key_expression(Some(given)).unwrap_err();
            assert_eq!(error.keys, format!("csat/*/{given}"));
            assert!(error.reason.starts_with(reason), "{given}: {}", error.reason);
            assert!(error.to_string().contains("expected such as `view/0/targets`"), "{error}");
        }
    }

    #[test]
    fn keys_are_known_by_when_something_comes() {
        for (given, expected) in [
            ("view/0/pose", Some(When::Flying)),
            ("link/**", Some(When::Flying)),
            ("csat/7/alive/world", Some(When::Token)),
            ("join/3", Some(When::Asked)),
            ("link/*/probe", Some(When::Rarely("before an agent flies"))),
            ("views/0/pose", None),
        ] {
            assert_eq!(when(&key_expression(Some(given)).unwrap()), expected, "{given}");
        }
    }

    #[test]
    fn a_slip_finds_its_key() {
        let heard = ["csat/1/view/0/pose", "csat/1/view/0/targets"];
        let near = |key: &str| nearest(key, heard.into_iter(), true);
        assert_eq!(near("csat/*/views/0/target").unwrap(), "csat/1/view/0/targets");
        assert_eq!(near("csat/*/truth/metric").unwrap(), "csat/*/truth/metrics");
        assert_eq!(near("csat/*/x"), None);
        assert_eq!(nearest("csat/*/truth/metric", heard.into_iter(), false), None);
    }
}
