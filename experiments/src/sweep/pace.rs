//! How long a sweep still takes.

use std::time::Duration;

use indicatif::HumanDuration;

use super::plan::Run;
use csat_mission::timing::Stopwatch;

/// What is known of how long missions take, and which ones are under way.
#[derive(Debug, Clone)]
pub struct Pace {
    jobs: usize,
    waiting: usize,
    under_way: Vec<(Run, Stopwatch)>,
    /// Of flown runs, seconds each.
    took: Mean,
    /// Of runs flown before this process, maybe by another machine: until one of its own has ended.
    took_before: Mean,
}

#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn get(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

impl Pace {
    /// Of `waiting` runs, `jobs` at a time, after others that took `before_s` seconds each.
    pub fn new(jobs: usize, waiting: usize, before_s: impl IntoIterator<Item = f64>) -> Self {
        let mut took_before = Mean::default();
        before_s.into_iter().for_each(|s| took_before.add(s));
        let jobs = jobs.clamp(1, waiting.max(1));
        Self { jobs, waiting, under_way: Vec::new(), took: Mean::default(), took_before }
    }

    /// A run takes off.
    pub fn start(&mut self, run: &Run) {
        self.waiting = self.waiting.saturating_sub(1);
        self.under_way.push((*run, Stopwatch::start()));
    }

    /// A run has ended; one that failed says nothing of how long others take.
    pub fn end(&mut self, run: &Run, is_flown: bool) {
        let Some(index) = self.under_way.iter().position(|(flies, _)| flies == run) else { return };
        let (_, watch) = self.under_way.remove(index);
        if is_flown {
            self.took.add(watch.elapsed_s());
        }
    }

    /// The time left, for people.
    pub fn left(&self) -> String {
        let Some(mean_s) = self.took.get().or(self.took_before.get()) else {
            return "after the first run".to_owned();
        };
        let since_s: Vec<f64> = self.under_way.iter().map(|(_, watch)| watch.elapsed_s()).collect();
        let left_s = left_s(mean_s, &since_s, self.waiting, self.jobs);
        format!("{:#}", HumanDuration(Duration::from_secs_f64(left_s.clamp(0.0, 1e9))))
    }
}

/// Seconds until all runs have ended if each takes `mean_s`: those under way since `since_s`, and `waiting`
/// ones that take off as soon as one of `jobs` is free.
fn left_s(mean_s: f64, since_s: &[f64], waiting: usize, jobs: usize) -> f64 {
    let mut free_at: Vec<f64> = since_s.iter().map(|since| (mean_s - since).max(0.0)).collect();
    free_at.resize(jobs.max(since_s.len()).max(1), 0.0);
    free_at.sort_by(f64::total_cmp);
    // All jobs get as many, and those that are free first get what remains.
    let (rounds, rest) = (waiting / free_at.len(), waiting % free_at.len());
    let ends = free_at.iter().enumerate().map(|(job, free_s)| {
        let runs = rounds + usize::from(job < rest);
        free_s + runs as f64 * mean_s
    });
    ends.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The case that was seen: six runs of four minutes each on two cores said "29h" in the first one.
    #[test]
    fn time_left_is_that_of_the_runs_left() {
        assert_eq!(left_s(240.0, &[], 6, 2), 720.0);
        assert_eq!(left_s(240.0, &[100.0, 40.0], 3, 2), 140.0 + 480.0);
        assert_eq!(left_s(240.0, &[100.0, 40.0], 4, 2), 200.0 + 480.0);
        assert_eq!(left_s(240.0, &[100.0], 0, 2), 140.0);
        assert_eq!(left_s(240.0, &[300.0], 0, 2), 0.0, "one that takes longer than the others");
        assert_eq!(left_s(10.0, &[], 0, 4), 0.0);
    }

    #[test]
    fn nothing_is_said_before_anything_is_known() {
        let [first, second] = [1, 2].map(|seed| Run { seed, point: 0 });
        let mut pace = Pace::new(2, 6, []);
        pace.start(&first);
        assert_eq!(pace.left(), "after the first run");
        pace.end(&first, false);
        assert_eq!(pace.left(), "after the first run");
        let mut resumed = Pace::new(2, 6, [200.0, 280.0]);
        resumed.start(&first);
        resumed.start(&second);
        assert_eq!(resumed.left(), "12m");
        // Its own runs count more: these took no time.
        resumed.end(&first, true);
        assert_eq!(resumed.left(), "0s");
    }
}
