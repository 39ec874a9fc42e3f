//! How many bytes an agent may send: a token bucket.

use csat_proto::time::SimTime;

/// The size of the bucket, seconds of the budget.
const BUCKET_S: f64 = 2.0;

/// Bytes that may be sent now.
#[derive(Debug, Clone)]
pub struct Budget {
    /// Bytes per second.
    rate: f64,
    tokens: f64,
    /// When tokens were last earned.
    at: Option<SimTime>,
}

impl Budget {
    /// An empty bucket for `rate` bytes per second; infinite for no limit.
    pub fn new(rate: f64) -> Self {
        Self { rate: rate.max(0.0), tokens: 0.0, at: None }
    }

    /// Whether there is a limit.
    pub fn is_limited(&self) -> bool {
        self.rate.is_finite()
    }

    /// Bytes per second.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Earns the bytes of the time since the last call, at first those of `first_s` seconds. The bucket is
    /// large enough for a message of `message` bytes.
    pub fn earn(&mut self, now: SimTime, first_s: f64, message: usize) {
        let seconds = self.at.map_or(first_s, |at| now.seconds_since(at));
        self.at = Some(self.at.map_or(now, |at| at.max(now)));
        self.tokens = match self.is_limited() {
            true => (self.tokens + self.rate * seconds).min(self.capacity().max(message as f64)),
            false => f64::INFINITY,
        };
    }

    /// Bytes that may be sent now.
    pub fn tokens(&self) -> f64 {
        self.tokens
    }

    /// The size of the bucket, bytes.
    pub fn capacity(&self) -> f64 {
        BUCKET_S * self.rate
    }

    /// A message of so many bytes was sent.
    pub fn spend(&mut self, bytes: usize) {
        self.tokens -= bytes as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bucket_has_two_seconds_or_a_message() {
        let at = SimTime::from_seconds;
        let mut budget = Budget::new(100.0);
        budget.earn(at(5.0), 0.5, 0);
        assert_eq!(budget.tokens(), 50.0);
        budget.spend(40);
        budget.earn(at(6.0), 0.5, 0);
        budget.earn(at(6.0), 0.5, 0);
        assert_eq!(budget.tokens(), 110.0);
        budget.earn(at(60.0), 0.5, 0);
        assert_eq!(budget.tokens(), 200.0);
        budget.earn(at(70.0), 0.5, 1000);
        budget.earn(at(60.0), 0.5, 1000);
        assert_eq!(budget.tokens(), 1000.0);
        let mut unlimited = Budget::new(f64::INFINITY);
        unlimited.earn(at(0.0), 0.0, 0);
        unlimited.spend(1 << 30);
        assert_eq!((unlimited.tokens(), unlimited.is_limited()), (f64::INFINITY, false));
        assert_eq!(Budget::new(f64::NAN).rate(), 0.0);
    }
}
