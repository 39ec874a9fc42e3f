//! Differences within a seed. Missions with the same seed have the same town, cars and starts wherever
//! what varies leaves them alone, so most of what differs between seeds cancels: a difference of means
//! needs many seeds to show what the mean of these differences shows with few.

use std::collections::BTreeMap;

use super::manifest::Manifest;
use super::plan::Point;
use super::record::RunRecord;
use super::results::Results;
use super::vary::Axis;
use crate::stats::{Stats, stats};

/// What the argument of `--against` is for perfect links.
pub const PERFECT: &str = "perfect";

/// What points are compared with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    /// What it is called, such as `agents.count=4`.
    pub name: String,
    /// The axis along which points differ from their reference; `None` for perfect links.
    pub axis: Option<usize>,
    /// Per point, the one that it is compared with; `None` where there is none.
    pub of: Vec<Option<usize>>,
}

impl Reference {
    /// What `against` names: `KEY=VALUE` of what varies, or `perfect`. Without it perfect links if they are
    /// flown for comparison, else the first value of the first key; `None` where there is nothing to
    /// compare.
    ///
    /// # Errors
    /// What is wrong and what was expected.
    pub fn new(manifest: &Manifest) -> Result<Option<Self>, String> {
        let reference = match &manifest.against {
            Some(text) if text == PERFECT => Some(Self::perfect(manifest)),
            Some(text) => Some(Self::value(manifest, text)?),
            None => {
                let perfect = manifest.baseline.then(|| Self::perfect(manifest));
                let first = || (!manifest.vary.is_empty()).then(|| Self::along(manifest, 0, 0));
                perfect.filter(Self::compares).or_else(first)
            }
        };
        match reference.filter(Self::compares) {
            None if manifest.against.is_some() => {
                Err("no combination has what it would be compared with".to_owned())
            }
            reference => Ok(reference),
        }
    }

    /// Whether any point has one to be compared with.
    fn compares(&self) -> bool {
        self.of.iter().any(Option::is_some)
    }

    fn perfect(manifest: &Manifest) -> Self {
        let like = |point: &Point| manifest.perfect_like(&point.choice).filter(|_| !point.perfect);
        let of = manifest.points.iter().map(like).collect();
        Self { name: "perfect links".to_owned(), axis: None, of }
    }

    fn value(manifest: &Manifest, text: &str) -> Result<Self, String> {
        let axes = || manifest.vary.iter().map(|axis| format!("`{}`", axis.argument()));
        let expected = || format!("expected a value of {}", axes().collect::<Vec<_>>().join(", "));
        let Some((key, value)) = text.split_once('=') else {
            return Err(format!("`{text}` is no KEY=VALUE; {} or `{PERFECT}`", expected()));
        };
        let key: String = key.split_whitespace().collect();
        let axis = manifest.vary.iter().position(|axis| axis.keys.join(",") == key);
        let Some(axis) = axis else {
            return Err(format!("`{key}` does not vary; {}", expected()));
        };
        let value = value.trim();
        let wanted = Axis::parse(&format!("{key}={value}")).ok();
        let is_wanted = |choice: &super::vary::Choice| {
            let same = wanted.as_ref().is_some_and(|w| choice.is_same_value(&w.values[0]));
            same || choice.label.as_deref() == Some(value)
        };
        match manifest.vary[axis].values.iter().position(is_wanted) {
            Some(index) => Ok(Self::along(manifest, axis, index)),
            None => Err(format!("`{key}` has no value `{value}`; {}", expected())),
        }
    }

    fn along(manifest: &Manifest, axis: usize, value: usize) -> Self {
        let like = |point: &Point| {
            let mut choice = point.choice.clone();
            choice[axis] = Some(value);
            let index = manifest.combination(&choice)?;
            (manifest.points[index] != *point).then_some(index)
        };
        let of = manifest.points.iter().map(like).collect();
        let Axis { values, .. } = &manifest.vary[axis];
        let name = format!("{}={}", manifest.vary[axis].title(), values[value].shown());
        Self { name, axis: Some(axis), of }
    }
}

/// What the differences within a seed come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Paired {
    /// Seeds in ascending order, each with its difference.
    pub differences: Vec<(u64, f64)>,
    /// Of the differences.
    pub stats: Stats,
    /// How many of them are negative.
    pub lower: usize,
    /// How many of them are positive.
    pub higher: usize,
}

impl Paired {
    /// Of values by seed: those of `of` less those of `reference`, for the seeds that both have; `None` when
    /// there is no such seed.
    pub fn new(of: &BTreeMap<u64, f64>, reference: &BTreeMap<u64, f64>) -> Option<Self> {
        let both = of.iter().filter_map(|(seed, v)| Some((*seed, v - reference.get(seed)?)));
        let differences: Vec<(u64, f64)> = both.collect();
        let stats = stats(&differences.iter().map(|(_, d)| *d).collect::<Vec<_>>())?;
        let count = |is: fn(f64) -> bool| differences.iter().filter(|(_, d)| is(*d)).count();
        let (lower, higher) = (count(|d| d < 0.0), count(|d| d > 0.0));
        Some(Self { differences, stats, lower, higher })
    }

    /// Of a number at a point and at the one that it is compared with.
    pub fn at(
        results: &Results,
        [point, reference]: [usize; 2],
        number: impl Fn(&RunRecord) -> Option<f64>,
    ) -> Option<Self> {
        let [of, reference] = [point, reference].map(|point| by_seed(results, point, &number));
        Self::new(&of, &reference)
    }

    /// Whether 0 is outside of the 95 % confidence interval of the mean; `None` for a single seed.
    pub fn is_clear(&self) -> Option<bool> {
        self.stats.half_width.map(|reach| self.stats.mean.abs() > reach)
    }
}

/// A number of the flown runs of a point that have it, by seed.
pub fn by_seed(
    results: &Results,
    point: usize,
    number: impl Fn(&RunRecord) -> Option<f64>,
) -> BTreeMap<u64, f64> {
    results.flown(point).filter_map(|record| Some((record.seed, number(record)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::manifest::tests::sample;
    use crate::sweep::metric::metric;
    use crate::sweep::results::tests::made_up;

    fn reference(vary: &[&str], against: Option<&str>) -> Result<Option<Reference>, String> {
        let mut manifest = sample(vary, "1..3");
        manifest.against = against.map(str::to_owned);
        Reference::new(&manifest)
    }

    #[test]
    fn points_are_compared_with_what_differs_in_one_respect() {
        let first = reference(&["a=1,2,3", "b=x,y"], None).unwrap().unwrap();
        assert_eq!((first.name.as_str(), first.axis), ("a=1", Some(0)));
        assert_eq!(first.of, [None, None, Some(0), Some(1), Some(0), Some(1)]);
        let named = reference(&["a=1,2,3", "b=x,y"], Some("b = 'y'")).unwrap().unwrap();
        assert_eq!(named.of, [Some(1), None, Some(3), None, Some(5), None]);
        let together = reference(&["a,b=p:(1,2),(3,4)"], Some("a,b=p")).unwrap().unwrap();
        assert_eq!(together.of, [None, Some(0)]);
        assert_eq!(together.name, "a, b=p");
        let links = reference(&["netem.radio.range_m=20,60", "a=1,2"], None).unwrap().unwrap();
        assert_eq!((links.name.as_str(), links.axis), ("perfect links", None));
        assert_eq!(links.of, [Some(4), Some(5), Some(4), Some(5), None, None]);
        let mut all_perfect = sample(&["a=1,2"], "1");
        all_perfect.baseline = true;
        all_perfect.points.iter_mut().for_each(|point| point.perfect = true);
        assert_eq!(Reference::new(&all_perfect).unwrap().unwrap().of, [None, Some(0)]);
        assert_eq!(reference(&[], None).unwrap(), None);
        assert_eq!(reference(&["a=1"], None).unwrap(), None);
    }

    #[test]
    fn what_cannot_be_compared_with_is_named() {
        let refused = |against| reference(&["a=1,2", "b=x,y"], Some(against)).unwrap_err();
        assert_eq!(
            refused("a"),
            "`a` is no KEY=VALUE; expected a value of `a=1,2`, `b=x,y` or `perfect`"
        );
        assert_eq!(refused("c=1"), "`c` does not vary; expected a value of `a=1,2`, `b=x,y`");
        assert!(refused("a=3").starts_with("`a` has no value `3`; expected"));
        assert_eq!(refused("perfect"), "no combination has what it would be compared with");
    }

    /// By hand: differences -1, -2 and -3 have mean -2, deviation 1, and 4.3027 / √3 = 2.4842.
    #[test]
    fn differences_by_hand() {
        let of = BTreeMap::from([(1, 4.0), (2, 8.0), (3, 1.0), (7, 9.0)]);
        let reference = BTreeMap::from([(1, 5.0), (2, 10.0), (3, 4.0), (9, 0.0)]);
        let paired = Paired::new(&of, &reference).unwrap();
        assert_eq!(paired.differences, [(1, -1.0), (2, -2.0), (3, -3.0)]);
        assert_eq!((paired.stats.mean, paired.stats.sd), (-2.0, Some(1.0)));
        assert!((paired.stats.half_width.unwrap() - 2.484_138).abs() < 1e-5);
        assert_eq!((paired.lower, paired.higher, paired.is_clear()), (3, 0, Some(false)));
        assert_eq!(Paired::new(&of, &BTreeMap::new()), None);
        let one = Paired::new(&BTreeMap::from([(1, 4.0)]), &reference).unwrap();
        assert_eq!((one.stats.half_width, one.is_clear()), (None, None));
    }

    /// Seeds that failed or are missing at one of two points are no pair.
    #[test]
    fn only_seeds_that_both_have_are_paired() {
        let results = made_up(&["a=1,2"], "1..4");
        let paired = |key| Paired::at(&results, [1, 0], |record| metric(record, key)).unwrap();
        let seeds: Vec<u64> =
            paired("unexplored_pct").differences.iter().map(|(seed, _)| *seed).collect();
        assert_eq!(seeds, [1, 2, 4]);
        assert!(paired("unexplored_pct").stats.mean < -1.0);
    }
}
