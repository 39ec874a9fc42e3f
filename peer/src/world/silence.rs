//! When the world received nothing from a process: it is stopped, too slow or gone.

/// When the world received nothing from an agent's process, in simulated time.
#[derive(Debug, Default)]
pub struct Silence {
    /// The silence that lasts, if any, from and to, seconds.
    current_s: Option<(f64, f64)>,
    /// Those that are over and were long enough to count.
    past_s: Vec<[f64; 2]>,
    /// Whether the one that lasts is long enough to count.
    counts: bool,
}

impl Silence {
    /// The step from `from_s` to `to_s` is over; `has_sent`: the process sent something in it. Returns
    /// whether the silence has just become longer than `least_s`; a shorter one does not count.
    pub fn note(&mut self, (from_s, to_s): (f64, f64), has_sent: bool, least_s: f64) -> bool {
        if has_sent {
            let past = self.current_s.take().filter(|_| std::mem::take(&mut self.counts));
            self.past_s.extend(past.map(|(from_s, to_s)| [from_s, to_s]));
            return false;
        }
        let since_s = self.current_s.map_or(from_s, |(since_s, _)| since_s);
        self.current_s = Some((since_s, to_s));
        let is_long = to_s - since_s > least_s;
        is_long && !std::mem::replace(&mut self.counts, is_long)
    }

    /// How long the silence that lasts has lasted, seconds.
    pub fn lasts_s(&self) -> f64 {
        self.current_s.map_or(0.0, |(from_s, to_s)| to_s - from_s)
    }

    /// All that were long enough to count, from and to, seconds.
    pub fn spans_s(&self) -> Vec<[f64; 2]> {
        let current = self.current_s.filter(|_| self.counts).map(|(from_s, to_s)| [from_s, to_s]);
        self.past_s.iter().copied().chain(current).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silence_is_from_its_first_step_to_its_last() {
        let mut silence = Silence::default();
        let mut long = Vec::new();
        // Two seconds from 1 s on, which count, and one from 4 s on, which does not.
        for (step, has_sent) in
            [true, false, false, true, false, true, false, false].iter().enumerate()
        {
            let from_s = step as f64;
            if silence.note((from_s, from_s + 1.0), *has_sent, 1.0) {
                long.push((step, silence.lasts_s()));
            }
        }
        assert_eq!(long, [(2, 2.0), (7, 2.0)]);
        assert_eq!(silence.spans_s(), [[1.0, 3.0], [6.0, 8.0]], "the last one lasts");
        assert!(!silence.note((8.0, 9.0), false, 1.0), "it is reported once");
        assert_eq!(silence.spans_s()[1], [6.0, 9.0]);
    }
}
