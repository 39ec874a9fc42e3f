//! Numbers beside axes.

/// A number in few characters.
pub fn short(n: f64) -> String {
    let size = n.abs();
    let with = |value: f64, ending: &str| {
        let text = format!("{value:.2}");
        format!("{}{ending}", text.trim_end_matches('0').trim_end_matches('.'))
    };
    match size {
        0.0 => "0".to_owned(),
        s if s >= 1e9 => with(n / 1e9, "G"),
        s if s >= 1e6 => with(n / 1e6, "M"),
        s if s >= 1e4 => with(n / 1e3, "k"),
        s if s >= 100.0 => {
            let text = format!("{n:.1}");
            text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
        }
        s if s < 1e-3 => format!("{n:e}"),
        _ => {
            let text = format!("{n:.4}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}

/// 1, 2 or 5 times a power of ten, at least so much.
pub fn step(at_least: f64) -> f64 {
    let power = 10f64.powf(at_least.max(1e-12).log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= at_least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}
