use std::collections::BTreeMap;

use super::read::Folder;
use super::{Comparison, Digests, Kind, Number, sides};
use crate::sweep::results::Results;
use crate::sweep::results::tests::made_up;

fn sweeps(a: Results, b: Results) -> Result<Comparison, String> {
    let [a, b] = [a, b].map(|results| Folder::Sweep(Box::new(results)));
    sides::compare(["one", "two"].map(str::to_owned), &a, &b).map_err(|error| error.to_string())
}

fn number<'a>(comparison: &'a Comparison, part: &str, key: &str) -> &'a Number {
    let part = comparison.parts.iter().find(|p| p.name == part).expect(part);
    part.numbers.iter().find(|number| number.key == key).expect(key)
}

/// The results of another sweep in which every mission leaves so much more unexplored.
fn worse(mut results: Results, by: f64) -> Results {
    for (_, record) in &mut results.runs {
        if let Some(summary) = record.as_mut().and_then(|record| record.summary.as_mut()) {
            let value = summary["unexplored_pct"].as_f64().unwrap();
            summary["unexplored_pct"] =
                (value + by + 0.1 * summary["seed"].as_f64().unwrap()).into();
            summary["digest"] = "other".into();
        }
    }
    results
}

#[test]
fn a_sweep_is_equal_to_itself() {
    let same = sweeps(made_up(&["a=1,2"], "1..4"), made_up(&["a=1,2"], "1..4")).unwrap();
    assert_eq!((same.kind, same.scenario.len(), same.parts.len()), (Kind::Sweep, 0, 2));
    assert_eq!(same.digests, Some(Digests { equal: 7, different: 0 }));
    assert!(same.parts.iter().all(|part| part.numbers.iter().all(|n| !n.differs())));
    assert!(same.text().contains("digests: 7 equal of 7 runs in common\n"), "{}", same.text());
    assert!(same.notes.contains(&"one: 1 of 8 runs failed, 0 are missing".to_owned()));
}

#[test]
fn values_that_both_have_are_compared_within_seeds() {
    let one = made_up(&["b=x", "a=1,2"], "1..4");
    let two = worse(made_up(&["a=2,3", "b=x"], "2..5"), 1.0);
    let both = sweeps(one, two).unwrap();
    assert_eq!(both.parts.len(), 1);
    let unexplored = number(&both, "b=x, a=2", "unexplored_pct");
    assert_eq!((unexplored.lower + unexplored.higher, unexplored.n), (unexplored.n, unexplored.n));
    assert!(unexplored.n >= 2 && unexplored.ci95_half_width.is_some());
    let digests = both.digests.unwrap();
    assert_eq!((digests.equal, digests.different), (0, unexplored.n));
    assert!(both.notes.contains(&"only one has b=x, a=1".to_owned()), "{:?}", both.notes);
    assert!(both.notes.contains(&"only two has a=3, b=x".to_owned()), "{:?}", both.notes);
    let text = both.text();
    assert!(text.contains("b=x, a=2\n") && text.contains("seeds  lower  higher\n"), "{text}");
}

#[test]
fn what_has_nothing_in_common_is_refused() {
    let refused = sweeps(made_up(&["a=1"], "1"), made_up(&["c=1"], "1")).unwrap_err();
    assert!(
        refused.starts_with(
            "error: `one` (which varies `a`) and `two` (which varies `c`) have no combination"
        ),
        "{refused}"
    );
    let tables = Folder::Tables(Vec::new());
    let sweep = Folder::Sweep(Box::new(made_up(&["a=1"], "1")));
    let refused = sides::compare(["one", "two"].map(str::to_owned), &sweep, &tables).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "error: `one` is the folder of a sweep, `two` is the folder of a reproduction without missions\n  \
         = expected two runs, two sweeps or two reproductions"
    );
}

#[test]
fn tables_are_compared_cell_by_cell() {
    let table = |mean| vec![("T".to_owned(), BTreeMap::from([("r: c".to_owned(), mean)]))];
    let [a, b] = [table(2.0), table(1.5)].map(Folder::Tables);
    let both = sides::compare(["one", "two"].map(str::to_owned), &a, &b).unwrap();
    let cell = number(&both, "T", "r: c");
    assert_eq!((cell.a, cell.b, cell.difference), (Some(2.0), Some(1.5), Some(-0.5)));
    assert!(
        both.text().contains("\nT\n        a    b  b - a\n  r: c  2  1.5   -0.5\n"),
        "{}",
        both.text()
    );
}
