//! `--seeds 1..5` and `--shard 2/3`.

use std::collections::BTreeSet;

/// The most seeds of one sweep.
const MAX_SEEDS: u64 = 1_000_000;

/// Parses seeds: `1..5` is 1, 2, 3, 4, 5; `1,4,7` is those; both mix.
///
/// # Errors
/// What is wrong and what was expected.
pub fn parse_seeds(text: &str) -> Result<Vec<u64>, String> {
    let mut seeds = Vec::new();
    for piece in text.split(',').map(str::trim) {
        let number = |text: &str| {
            let text = text.trim();
            text.parse::<u64>().ok().filter(|n| *n <= i64::MAX as u64).ok_or_else(|| {
                format!(
                    "`{text}` is not a seed; expected whole numbers from 0, such as `1..5` (both \
                     ends included) or `1,4,7`"
                )
            })
        };
        let (first, last) = match piece.split_once("..") {
            Some((first, last)) => {
                (number(first)?, number(last.strip_prefix('=').unwrap_or(last))?)
            }
            None => (number(piece)?, number(piece)?),
        };
        if first > last {
            return Err(format!("`{piece}` has no seed in it: {first} is after {last}"));
        }
        if last - first >= MAX_SEEDS - seeds.len() as u64 {
            return Err(format!("`{text}` has more than {MAX_SEEDS} seeds"));
        }
        seeds.extend(first..=last);
    }
    let mut seen = BTreeSet::new();
    match seeds.iter().find(|seed| !seen.insert(**seed)) {
        Some(twice) => Err(format!("seed {twice} is there twice")),
        None => Ok(seeds),
    }
}

/// Seeds in few words, to be parsed again.
pub fn seeds_text(seeds: &[u64]) -> String {
    let runs = seeds.chunk_by(|a, b| a.checked_add(1) == Some(*b));
    let pieces = runs.map(|run| match run {
        [only] => only.to_string(),
        [a, b] => format!("{a},{b}"),
        run => format!("{}..{}", run[0], run[run.len() - 1]),
    });
    pieces.collect::<Vec<_>>().join(",")
}

/// One of several parts of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which one, from 1.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

impl Shard {
    /// The whole sweep.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Parses `i/n`.
    ///
    /// # Errors
    /// What is wrong and what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').map(|(i, n)| (i.trim().parse(), n.trim().parse()));
        match parts {
            Some((Ok(index), Ok(count))) if (1..=count).contains(&index) => {
                Ok(Self { index, count })
            }
            _ => Err(format!(
                "there is no shard `{text}`; expected `i/n` with i from 1 to n, such as `1/3`, \
                 `2/3` and `3/3`"
            )),
        }
    }

    /// Whether the run with this number, from 0, is its part.
    pub fn has(&self, number: usize) -> bool {
        number % self.count == self.index - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_both_ends_and_mix_with_lists() {
        assert_eq!(parse_seeds("1..5").unwrap(), [1, 2, 3, 4, 5]);
        assert_eq!(parse_seeds("1..=2").unwrap(), [1, 2]);
        assert_eq!(parse_seeds("7, 1..3,9").unwrap(), [7, 1, 2, 3, 9]);
        assert_eq!(parse_seeds("4..4").unwrap(), [4]);
        assert_eq!(parse_seeds("9223372036854775807").unwrap(), [i64::MAX as u64]);
        for text in ["1..5", "7,1..3,9", "1,2", "9223372036854775807"] {
            assert_eq!(seeds_text(&parse_seeds(text).unwrap()), text);
        }
    }

    #[test]
    fn what_is_no_seed_is_named() {
        for (text, message) in [
            ("5..1", "`5..1` has no seed in it: 5 is after 1"),
            ("1..3,2", "seed 2 is there twice"),
            ("", "`` is not a seed"),
            ("a..3", "`a` is not a seed"),
            ("-1", "`-1` is not a seed"),
            ("1..", "`` is not a seed"),
            ("9223372036854775808", "is not a seed"),
            ("0..9223372036854775807", "has more than 1000000 seeds"),
        ] {
            let error = parse_seeds(text).unwrap_err();
            assert!(error.starts_with(message) || error.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn shards_count_from_one_and_share_everything() {
        for text in ["5/4", "0/3", "1", "1/0", "a/b", "-1/2", ""] {
            assert!(Shard::parse(text).unwrap_err().contains("there is no shard"), "{text}");
        }
        let shards: Vec<Shard> =
            (1..=3).map(|i| Shard::parse(&format!("{i}/3")).unwrap()).collect();
        for number in 0..10 {
            assert_eq!(shards.iter().filter(|s| s.has(number)).count(), 1);
        }
        assert!((0..10).all(|n| Shard::WHOLE.has(n)));
    }
}
