//! Since when nothing is heard of a process: it is stopped, starved or gone.

/// When nothing was heard of an agent's process, in simulated time.
#[derive(Debug, Default)]
pub struct Silence {
    /// The silence that lasts, if any, from and to, seconds.
    now_s: Option<(f64, f64)>,
    /// Those that are over and long enough.
    over_s: Vec<[f64; 2]>,
    /// Whether the one that lasts has been told.
    is_told: bool,
}

impl Silence {
    /// The step from `from_s` to `to_s` is over, and something was heard in it or not. Tells whether the
    /// silence has just become longer than `least_s`; shorter ones do not count.
    pub fn note(&mut self, (from_s, to_s): (f64, f64), is_heard: bool, least_s: f64) -> bool {
        if is_heard {
            let over = self.now_s.take().filter(|_| std::mem::take(&mut self.is_told));
            self.over_s.extend(over.map(|(from_s, to_s)| [from_s, to_s]));
            return false;
        }
        let since_s = self.now_s.map_or(from_s, |(since_s, _)| since_s);
        self.now_s = Some((since_s, to_s));
        let is_long = to_s - since_s > least_s;
        is_long && !std::mem::replace(&mut self.is_told, is_long)
    }

    /// How long the silence that lasts has lasted, seconds.
    pub fn lasts_s(&self) -> f64 {
        self.now_s.map_or(0.0, |(from_s, to_s)| to_s - from_s)
    }

    /// All that were long enough, from and to, seconds.
    pub fn spans_s(&self) -> Vec<[f64; 2]> {
        let now = self.now_s.filter(|_| self.is_told).map(|(from_s, to_s)| [from_s, to_s]);
        self.over_s.iter().copied().chain(now).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silence_is_from_its_first_step_to_its_last() {
        let mut silence = Silence::default();
        let mut told = Vec::new();
        // Two seconds from 1 s on, which count, and one from 4 s on, which does not.
        for (step, is_heard) in
            [true, false, false, true, false, true, false, false].iter().enumerate()
        {
            let from_s = step as f64;
            if silence.note((from_s, from_s + 1.0), *is_heard, 1.0) {
                told.push((step, silence.lasts_s()));
            }
        }
        assert_eq!(told, [(2, 2.0), (7, 2.0)]);
        assert_eq!(silence.spans_s(), [[1.0, 3.0], [6.0, 8.0]], "the last one lasts");
        assert!(!silence.note((8.0, 9.0), false, 1.0), "it is told once");
        assert_eq!(silence.spans_s()[1], [6.0, 9.0]);
    }
}
