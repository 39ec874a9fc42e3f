//! What is wrong with the values of a scenario.

use super::mistake::Mistake;

/// A value that cannot be.
#[derive(Debug, Clone)]
pub struct Issue {
    /// The keys that it depends on; the place is that of the first one that the user wrote.
    pub keys: Vec<String>,
    /// What to say.
    pub mistake: Mistake,
    /// Whether the mission may fly all the same.
    pub is_warning: bool,
}

impl Issue {
    /// A value that is refused; `keys` begins with its own key, and goes on with those that it depends on.
    pub fn refused(keys: &[&str], got: &str, expected: &str) -> Self {
        let mistake = Mistake::new(format!("`{}` cannot be {got}", keys[0])).expected(expected);
        Self { keys: owned(keys), mistake, is_warning: false }
    }
}

pub(super) fn owned(keys: &[&str]) -> Vec<String> {
    keys.iter().map(|key| (*key).to_owned()).collect()
}
