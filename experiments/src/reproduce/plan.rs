//! What is flown: fixed sweeps of shipped scenarios.

use super::setting::Deviations;
use crate::scenario::Mistakes;
use crate::sweep::manifest::{Manifest, Request, quoted};
use crate::sweep::plan::clashes;
use crate::sweep::vary::Axis;

/// How many missions the published means are of, by criterion; of Gagliardi et al., csat's own choice.
const MISSIONS: usize = 10;

/// A fixed sweep.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// What the command line calls it.
    pub name: &'static str,
    /// What its page is called.
    pub title: &'static str,
    /// The scenario.
    source: &'static str,
    /// What varies, as `--vary` takes it; its labels name the rows of the tables.
    vary: Option<&'static str>,
    /// What is not as in the scenario, as `--set` takes it.
    sets: &'static [&'static str],
}

/// Thesis §5.4: `city` has its setting, with perfect links and `sequential-loopback`.
pub const CHAPTER5: Plan = Plan {
    name: "chapter5",
    title: "Thesis chapter 5, ours beside theirs",
    source: "city",
    vary: Some(
        "guidance.criterion,guidance.kappa=str1:(str1,1),str2-no-hidden:(str2-no-hidden,1),\
         str2:(str2,1),str3-kappa0:(str3,0),str3-kappa1:(str3,1)",
    ),
    sets: &[],
};

/// The paper's table I: r_s = 3 m, the least distance of a car's location from obstacles. What it
/// calls previous work plans by the criterion (5.21), which does not use the map.
pub const TABLE1: Plan = Plan {
    name: "table1",
    title: "The paper's table I, ours beside theirs",
    source: "city",
    vary: Some(
        "guidance.criterion,guidance.kappa=previous:(str2,1),kappa0:(str3,0),kappa1:(str3,1)",
    ),
    sets: &["targets.obstacle_distance_m=3"],
};

/// Gagliardi et al. §VI: `clearing` has its setting; each seed is another network.
pub const CLEARING: Plan = Plan {
    name: "clearing",
    title: "Gagliardi et al. 2014, ours beside theirs",
    source: "clearing",
    vary: None,
    sets: &[],
};

impl Plan {
    /// The sweep, with the user's own `--set` after its own.
    ///
    /// # Errors
    /// A `--set` of what the plan varies.
    pub fn request(&self, seeds: Vec<u64>, sets: &[String]) -> Result<Request, Mistakes> {
        let axes: Result<Vec<Axis>, _> = self.vary.into_iter().map(Axis::parse).collect();
        let axes = axes.map_err(|mistake| Mistakes::from(vec![mistake]))?;
        let mistakes = clashes(&axes, sets);
        if !mistakes.is_empty() {
            return Err(mistakes.into());
        }
        let fixed = self.sets.iter().map(|&set| set.to_owned());
        let sets = fixed.chain(sets.iter().cloned()).collect();
        Ok(Request {
            source: self.source.to_owned(),
            sets,
            axes,
            seeds,
            baseline: false,
            against: None,
        })
    }

    /// What differs from the published setting, with the user's own `--set`.
    ///
    /// # Errors
    /// Mistakes in the sets.
    pub fn deviations(&self, missions: usize, sets: &[String]) -> Result<Deviations, Mistakes> {
        let plan: Vec<String> = self.sets.iter().map(|&set| set.to_owned()).collect();
        Deviations::of(Some(self.source), (missions, MISSIONS, "missions"), &plan, sets)
    }

    /// The command that makes it again.
    pub fn command(&self, manifest: &Manifest) -> String {
        let own = manifest.sets.iter().skip(self.sets.len());
        let sets: String = own.map(|set| format!(" --set {}", quoted(set))).collect();
        format!("csat reproduce {} --seeds {}{sets}", self.name, manifest.seeds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_are_sweeps_and_keep_their_criteria() {
        for (plan, points) in [(CHAPTER5, 5), (TABLE1, 3)] {
            let request = plan.request(vec![1, 2], &["run.duration_s=5".to_owned()]).unwrap();
            assert_eq!(request.axes[0].values.len(), points);
            assert_eq!(request.sets.last().unwrap(), "run.duration_s=5");
            let refused = plan.request(vec![1], &["guidance.kappa=2".to_owned()]).unwrap_err();
            assert!(refused.to_string().contains("`guidance.kappa` varies"), "{refused}");
        }
        assert!(CLEARING.request(vec![1], &[]).unwrap().axes.is_empty());
    }
}
