//! Whether what is reproduced is what was published.

use crate::scenario::{Mistakes, Request, load};

/// What differs from the published setting, in words for people.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Deviations(Vec<String>);

impl Deviations {
    /// Of a reproduction of `scenario` (the default one if `None`) with `count` missions (or looks, as `thing` says) of `published`, and with the
    /// user's `sets` after those of the plan. A `--set` of what is so anyway is no deviation, and more
    /// seeds are none.
    ///
    /// # Errors
    /// Mistakes in the sets.
    pub fn of(
        name: Option<&str>,
        (count, published, thing): (usize, usize, &str),
        plan: &[String],
        sets: &[String],
    ) -> Result<Self, Mistakes> {
        let scenario = |sets: &[String]| {
            let request = Request { scenario: name, sets, seed: None };
            load(request).map(|loaded| loaded.scenario)
        };
        let mut found = Vec::new();
        if count < published {
            found.push(format!("{count} {thing} instead of {published}"));
        }
        if !sets.is_empty() {
            let as_published = scenario(plan)?;
            for set in sets {
                if scenario(&[plan, std::slice::from_ref(set)].concat())? != as_published {
                    found.push(set.clone());
                }
            }
        }
        Ok(Self(found))
    }

    /// What to say above tables and pages; `None` for the published setting.
    pub fn banner(&self) -> Option<String> {
        let Self(found) = self;
        (!found.is_empty()).then(|| {
            format!(
                "Not the published setting: {}. Differences from the published numbers mean nothing \
                 and are not marked.",
                found.join("; ")
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn banner(count: usize, sets: &[&str]) -> Option<String> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let plan = ["targets.obstacle_distance_m=3".to_owned()];
        Deviations::of(None, (count, 10, "missions"), &plan, &sets).unwrap().banner()
    }

    #[test]
    fn only_what_makes_a_difference_is_a_deviation() {
        assert_eq!(banner(10, &[]), None);
        assert_eq!(banner(20, &["run.duration_s=300", "agents.count=4"]), None);
        let short = banner(2, &["run.duration_s=4.0", "agents.count=4"]).unwrap();
        let start = "Not the published setting: 2 missions instead of 10; run.duration_s=4.0. ";
        assert!(short.starts_with(start), "{short}");
        assert!(banner(10, &["targets.obstacle_distance_m=2"]).is_some());
    }
}
