//! What the doctor tells.

use std::fmt;

use serde::Serialize;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// As it should be.
    Ok,
    /// Worth knowing.
    Note,
    /// May be a reason to hear nothing.
    Warning,
    /// Is a reason to hear nothing.
    Problem,
}

/// Something that was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub check: String,
    /// How bad it is.
    pub level: Level,
    /// What was found.
    pub text: String,
    /// What to do.
    pub advice: Option<String>,
}

impl Finding {
    fn new(level: Level, check: impl Into<String>, text: impl Into<String>) -> Self {
        Self { check: check.into(), level, text: text.into(), advice: None }
    }

    /// As it should be.
    pub fn ok(check: impl Into<String>, text: impl Into<String>) -> Self {
        Self::new(Level::Ok, check, text)
    }

    /// Worth knowing.
    pub fn note(check: impl Into<String>, text: impl Into<String>) -> Self {
        Self::new(Level::Note, check, text)
    }

    /// May be a reason to hear nothing.
    pub fn warning(check: impl Into<String>, text: impl Into<String>) -> Self {
        Self::new(Level::Warning, check, text)
    }

    /// Is a reason to hear nothing.
    pub fn problem(check: impl Into<String>, text: impl Into<String>) -> Self {
        Self::new(Level::Problem, check, text)
    }

    /// With what to do.
    pub fn advice(mut self, advice: impl Into<String>) -> Self {
        self.advice = Some(advice.into());
        self
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level = match self.level {
            Level::Ok => "ok",
            Level::Note => "note",
            Level::Warning => "warning",
            Level::Problem => "problem",
        };
        // Names come from strangers.
        let clean = |text: &str| text.replace(char::is_control, " ");
        write!(f, "{level:<8} {:<10} {}", self.check, clean(&self.text))?;
        match &self.advice {
            Some(advice) => write!(f, "\n  = {}", clean(advice)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_is_a_line_and_what_to_do() {
        let finding = Finding::problem("session", "nobody\x1b is there").advice("start one");
        assert_eq!(finding.to_string(), "problem  session    nobody  is there\n  = start one");
        let json = serde_json::to_value(Finding::ok("a", "b")).unwrap();
        assert_eq!(
            json,
            serde_json::json!({"check": "a", "level": "ok", "text": "b", "advice": null})
        );
        let levels = [Finding::note("a", ""), Finding::warning("a", "")].map(|f| f.to_string());
        assert!(levels[0].starts_with("note ") && levels[1].starts_with("warning "));
    }
}
