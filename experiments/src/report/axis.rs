//! Where values stand along an axis.

pub use crate::ticks::{short, step};

/// Above this ratio of the greatest to the least value, distances are ratios.
const LOGARITHMIC_FROM: f64 = 20.0;
/// Width of a character of a label, in units of its size.
const CHARACTER: f64 = 0.56;
/// How far labels lean that have no room, degrees.
pub const LEAN_DEG: f64 = 32.0;
/// Size of the labels, pixels.
pub const LABEL_PX: f64 = 12.0;
/// The longest label, characters.
const LONGEST: usize = 22;

/// The horizontal axis.
#[derive(Debug, Clone, PartialEq)]
pub struct XAxis {
    /// Per value of the axis, where it stands from 0 (left) to 1.
    pub at: Vec<f64>,
    /// Per value, its label.
    pub labels: Vec<String>,
    /// Name and unit.
    pub title: String,
    /// Whether the last value is infinite and stands apart.
    pub is_broken: bool,
    /// Whether values in between mean something.
    pub is_numeric: bool,
}

impl XAxis {
    /// Of a scenario in which nothing varies.
    pub fn of_one() -> Self {
        Self {
            at: vec![0.5],
            labels: vec!["as it is".to_owned()],
            title: "the scenario".to_owned(),
            is_broken: false,
            is_numeric: false,
        }
    }

    /// Of `keys` that vary together. Each value is a number, where it is one, and a text.
    pub fn of(keys: &[String], values: &[(Option<f64>, String)]) -> Self {
        let numbers: Option<Vec<f64>> = values.iter().map(|(number, _)| *number).collect();
        let numbers = numbers.filter(|all| all.iter().all(|n| *n > f64::NEG_INFINITY));
        let is_numeric = numbers.is_some();
        let (at, labels, scale) = match numbers {
            Some(numbers) => numeric(&numbers),
            None => {
                let count = values.len();
                let at = (0..count).map(|i| (i as f64 + 0.5) / count as f64).collect();
                (at, values.iter().map(|(_, text)| shortened(text)).collect(), "")
            }
        };
        let is_broken = values.iter().any(|(number, _)| *number == Some(f64::INFINITY));
        let title = format!("{}{}{scale}", keys.join(", "), unit(keys));
        Self { at, labels, title, is_broken: is_numeric && is_broken, is_numeric }
    }

    /// Numbers from one end to the other, with a label at each of `ticks`.
    pub fn between(title: &str, [from, to]: [f64; 2], ticks: &[f64]) -> Self {
        Self {
            at: ticks.iter().map(|tick| (tick - from) / (to - from)).collect(),
            labels: ticks.iter().map(|tick| short(*tick)).collect(),
            title: title.to_owned(),
            is_broken: false,
            is_numeric: true,
        }
    }

    /// Whether labels must lean to have room on so many pixels.
    pub fn leans(&self, width_px: f64) -> bool {
        let longest = self.labels.iter().map(|l| l.chars().count()).max().unwrap_or(0);
        let room = width_px / self.labels.len().max(1) as f64;
        !self.is_numeric && longest as f64 * LABEL_PX * CHARACTER > room - 6.0
    }

    /// Room that leaning labels take below the axis, pixels.
    pub fn leaning_px(&self) -> f64 {
        let longest = self.labels.iter().map(|l| l.chars().count()).max().unwrap_or(0);
        20.0 + longest as f64 * LABEL_PX * CHARACTER * LEAN_DEG.to_radians().sin()
    }

    /// The labels that do not touch one another on so many pixels, as indices of values. The ends
    /// come first.
    pub fn readable(&self, width_px: f64) -> Vec<usize> {
        if !self.is_numeric {
            return (0..self.at.len()).collect();
        }
        let mut order: Vec<usize> = (0..self.at.len()).collect();
        order.sort_by(|a, b| self.at[*a].total_cmp(&self.at[*b]));
        if order.len() > 2 {
            let last = order.remove(order.len() - 1);
            order.insert(1, last);
        }
        let half =
            |i: usize| (self.labels[i].chars().count() as f64 * CHARACTER / 2.0 + 0.4) * LABEL_PX;
        let mut taken: Vec<usize> = Vec::new();
        for i in order {
            let free =
                |j: &usize| (self.at[i] - self.at[*j]).abs() * width_px >= half(i) + half(*j);
            if taken.iter().all(free) {
                taken.push(i);
            }
        }
        taken.sort_unstable();
        taken
    }
}

fn shortened(label: &str) -> String {
    if label.chars().count() <= LONGEST {
        return label.to_owned();
    }
    label.chars().take(LONGEST - 1).chain(['…']).collect()
}

/// Places, labels and the name of the scale.
fn numeric(numbers: &[f64]) -> (Vec<f64>, Vec<String>, &'static str) {
    let finite = numbers.iter().copied().filter(|n| n.is_finite());
    let least = finite.clone().fold(f64::INFINITY, f64::min);
    let greatest = finite.fold(f64::NEG_INFINITY, f64::max);
    let is_log = least > 0.0 && greatest / least >= LOGARITHMIC_FROM;
    let has_infinity = numbers.contains(&f64::INFINITY);
    let place = |n: f64| if is_log { n.log10() } else { n };
    let (from, span) = (place(least), place(greatest) - place(least));
    let end = if has_infinity { 0.84 } else { 1.0 };
    let at = numbers.iter().map(|&n| {
        if n == f64::INFINITY {
            1.0
        } else if span > 0.0 {
            end * (place(n) - from) / span
        } else {
            0.5 * end
        }
    });
    let label = |n: &f64| if n.is_finite() { short(*n) } else { "∞".to_owned() };
    let scale = if is_log { ", logarithmic" } else { "" };
    (at.collect(), numbers.iter().map(label).collect(), scale)
}

/// With three or four digits that mean something.
pub fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return short(value);
    }
    let scale = 10f64.powf(2.0 - value.abs().log10().floor()).max(1e-9);
    if value.abs() >= 1000.0 && value.abs() < 1e4 {
        return format!("{value:.0}");
    }
    short((value * scale).round() / scale)
}

/// The unit that the name of a key ends with.
fn unit(keys: &[String]) -> &'static str {
    let [key] = keys else { return "" };
    let units = [
        ("bytes_s", " [bytes/s]"),
        ("_bytes", " [bytes]"),
        ("_m_s", " [m/s]"),
        ("_m", " [m]"),
        ("_s", " [s]"),
        ("_deg", " [°]"),
        ("_pct", " [%]"),
    ];
    units.iter().find(|(ending, _)| key.ends_with(ending)).map_or("", |(_, unit)| unit)
}

/// The vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct YAxis {
    /// The value at the bottom.
    pub low: f64,
    /// The value at the top.
    pub high: f64,
    /// Values with a label.
    pub ticks: Vec<f64>,
}

impl YAxis {
    /// Around values that are not below 0 and not above `top`.
    pub fn around(values: impl Iterator<Item = f64>, top: f64) -> Self {
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| v.is_finite()) {
            (least, greatest) = (least.min(value), greatest.max(value));
        }
        if least > greatest {
            (least, greatest) = (0.0, 1.0);
        }
        // Heights mean something from 0 only; where that would flatten everything, it is not there.
        let from_zero = least <= 0.5 * greatest || greatest <= 0.0;
        let room = if from_zero { greatest } else { greatest - least };
        let room = if room > 0.0 { room } else { greatest.abs().max(1.0) };
        let low = if from_zero { 0.0 } else { (least - 0.1 * room).max(0.0) };
        let high = if greatest > 0.0 { greatest + 0.08 * room } else { 1.0 };
        Self::with_ticks(low, high.min(top.max(greatest)))
    }

    /// Around differences, with 0 in it.
    pub fn across(values: impl Iterator<Item = f64>) -> Self {
        let ends = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
        let (low, high) = values.filter(|v| v.is_finite()).fold((0.0, 0.0), ends);
        let room = if high > low { 0.06 * (high - low) } else { 1.0 };
        Self::with_ticks(low - room, high + room)
    }

    fn with_ticks(low: f64, high: f64) -> Self {
        let step = step((high - low) / 5.0);
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        let ticks = (first..=last).map(|k| k as f64 * step).collect();
        Self { low, high, ticks }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(argument: &str) -> XAxis {
        let (key, values) = argument.split_once('=').unwrap();
        let values: Vec<_> =
            values.split(',').map(|text| (text.parse().ok(), text.to_owned())).collect();
        XAxis::of(&[key.to_owned()], &values)
    }

    #[test]
    fn far_numbers_stand_by_their_ratios_and_infinity_apart() {
        let x = axis("netem.radio.range_m=25,100,400,1600,inf");
        assert!(x.is_numeric && x.is_broken);
        assert_eq!(x.labels, ["25", "100", "400", "1600", "∞"]);
        assert!((x.at[1] - 0.28).abs() < 1e-12 && (x.at[3] - 0.84).abs() < 1e-12 && x.at[4] == 1.0);
        assert_eq!(x.title, "netem.radio.range_m [m], logarithmic");
        let near = axis("agents.count=2,4,6");
        assert_eq!((near.at, near.is_broken), (vec![0.0, 0.5, 1.0], false));
        assert_eq!(axis("a=0,100").title, "a");
        assert_eq!(axis("a=inf").at, [1.0]);
    }

    #[test]
    fn words_stand_side_by_side() {
        let x = axis("exchange.mode=facts,snapshot");
        assert_eq!((x.at.clone(), x.is_numeric), (vec![0.25, 0.75], false));
        assert!(!x.leans(500.0) && x.leans(100.0));
    }

    #[test]
    fn labels_do_not_touch() {
        let x = axis("a=1,1.001,1.002,2,3");
        assert_eq!(x.readable(500.0), [0, 3, 4]);
    }

    #[test]
    fn heights_start_at_zero_unless_that_flattens_everything() {
        let y = YAxis::around([2.0, 10.0].into_iter(), f64::INFINITY);
        assert_eq!((y.low, y.ticks), (0.0, vec![0.0, 5.0, 10.0]));
        let y = YAxis::around([98.0, 99.5].into_iter(), 100.0);
        assert!(y.low > 97.0 && y.high <= 100.0 && y.ticks.len() >= 3, "{y:?}");
        let y = YAxis::around([0.0, 0.0].into_iter(), f64::INFINITY);
        assert!(y.high > 0.0 && y.ticks.len() > 2);
        assert!(YAxis::around(std::iter::empty(), 1.0).ticks.len() > 2);
    }

    #[test]
    fn differences_stand_around_zero() {
        let y = YAxis::across([-3.0, 1.0].into_iter());
        assert!(y.low < -3.0 && y.high > 1.0 && y.ticks.contains(&0.0), "{y:?}");
        let none = YAxis::across([0.0].into_iter());
        assert!(none.low < 0.0 && none.high > 0.0 && none.ticks.contains(&0.0), "{none:?}");
    }

    #[test]
    fn numbers_are_short() {
        for (n, text) in [
            (0.0, "0"),
            (0.05, "0.05"),
            (1e-5, "1e-5"),
            (25.0, "25"),
            (1500.0, "1500"),
            (2.5e6, "2.5M"),
            (12_340.0, "12.34k"),
        ] {
            assert_eq!(short(n), text);
        }
    }
}
