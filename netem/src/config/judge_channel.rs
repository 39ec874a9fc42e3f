//! Checks of the values of a channel.

use super::judge::Judge;
use super::{ChannelConfig, DelayConfig, LossConfig, PropagationConfig};
use crate::trace::Trace;

/// The longest delay that a configuration may ask for, seconds: arrivals must fit a clock of
/// microseconds.
const MAX_DELAY_S: f64 = 1e6;

/// Judges `[netem.NAME]`.
pub(super) fn channel(judge: &mut Judge, name: &str, config: &ChannelConfig) {
    let ChannelConfig { range_m, corruption, duplication, loss, delay, rate, propagation, .. } =
        config;
    let what = format!("expected a distance of at least 0 m (or inf), got {range_m}");
    judge.demand(*range_m >= 0.0, format!("{name}.range_m"), what);
    judge.probability(format!("{name}.corruption"), "corruption", *corruption);
    judge.probability(format!("{name}.duplication"), "duplication", *duplication);
    let what = format!("expected a rate above 0 bytes/s (or inf), got {}", rate.bytes_s);
    judge.demand(rate.bytes_s > 0.0, format!("{name}.rate.bytes_s"), what);
    let what = format!("expected 0 to 180 degrees, got {}", config.bearing_error_deg);
    let is_angle = (0.0..=180.0).contains(&config.bearing_error_deg);
    judge.demand(is_angle, format!("{name}.bearing_error_deg"), what);
    if let Some(error_m) = config.offset_error_m {
        judge.amount(format!("{name}.offset_error_m"), "offset_error_m", "m", error_m);
    }
    loss_mistakes(judge, &format!("{name}.loss"), loss);
    delay_mistakes(judge, &format!("{name}.delay"), delay);
    if let Some(propagation) = propagation {
        propagation_mistakes(judge, &format!("{name}.propagation"), propagation);
    }
}

fn loss_mistakes(judge: &mut Judge, key: &str, loss: &LossConfig) {
    let mut probabilities = |all: &[(&str, f64)]| {
        for (name, p) in all {
            judge.probability(format!("{key}.{name}"), name, *p);
        }
    };
    match loss {
        LossConfig::Iid { p } => probabilities(&[("p", *p)]),
        LossConfig::GilbertElliott { p, r, h, k } => {
            probabilities(&[("p", *p), ("r", *r), ("h", *h), ("k", *k)]);
            let what = "expected p + r above 0: no state is ever left, got p = 0 and r = 0";
            judge.demand(p + r != 0.0, format!("{key}.p"), what.to_owned());
        }
        LossConfig::Markov4 { p13, p31, p32, p23, p14 } => {
            let all = [("p13", *p13), ("p31", *p31), ("p32", *p32), ("p23", *p23), ("p14", *p14)];
            probabilities(&all);
            let rows = [("p13", "p14", p13 + p14), ("p31", "p32", p31 + p32)];
            for (first, second, sum) in rows {
                let what = format!("expected {first} + {second} of at most 1, got {sum}");
                // Values that are no probabilities are reported above.
                judge.demand(sum <= 1.0 || sum.is_nan(), format!("{key}.{first}"), what);
            }
            let what = "expected p31 above 0: with p13 above 0 no burst would ever end, got 0";
            judge.demand(*p31 != 0.0 || *p13 == 0.0, format!("{key}.p31"), what.to_owned());
            let what = "expected p23 above 0: with p32 above 0 state 2 is never left, got 0";
            judge.demand(*p23 != 0.0 || *p32 == 0.0, format!("{key}.p23"), what.to_owned());
        }
        LossConfig::Trace { file, lost } => match (file, lost) {
            (None, None) => {
                judge.demand(false, key, "expected a trace: `file` or `lost`".to_owned());
            }
            (Some(_), Some(_)) => {
                judge.demand(false, key, "expected `file` or `lost`, got both".to_owned());
            }
            (Some(file), None) => {
                judge.demand(false, format!("{key}.file"), format!("{file} was not read"));
            }
            (None, Some(text)) => {
                if let Err(error) = Trace::parse(text) {
                    judge.demand(false, format!("{key}.lost"), error.to_string());
                }
            }
        },
    }
}

fn delay_mistakes(judge: &mut Judge, key: &str, delay: &DelayConfig) {
    let mut seconds = |name: &str, value: f64| {
        judge.amount(format!("{key}.{name}"), name, "s", value);
        let what = format!("expected a {name} of at most {MAX_DELAY_S} s, got {value}");
        let too_long = value.is_finite() && value > MAX_DELAY_S;
        judge.demand(!too_long, format!("{key}.{name}"), what);
    };
    let correlation = match delay {
        DelayConfig::Constant { mean_s } => {
            seconds("mean_s", *mean_s);
            0.0
        }
        DelayConfig::Uniform { mean_s, spread_s, correlation } => {
            seconds("mean_s", *mean_s);
            seconds("spread_s", *spread_s);
            let what =
                format!("expected a spread_s of at most mean_s = {mean_s} s, got {spread_s}");
            let unordered = spread_s.is_nan() || mean_s.is_nan();
            judge.demand(spread_s <= mean_s || unordered, format!("{key}.spread_s"), what);
            *correlation
        }
        DelayConfig::Normal { mean_s, sd_s, correlation } => {
            seconds("mean_s", *mean_s);
            seconds("sd_s", *sd_s);
            *correlation
        }
        DelayConfig::Pareto { mean_s, shape, correlation } => {
            seconds("mean_s", *mean_s);
            let what = format!("expected a finite shape above 1, got {shape}");
            judge.demand(*shape > 1.0 && shape.is_finite(), format!("{key}.shape"), what);
            *correlation
        }
        DelayConfig::Table { quantiles_s, correlation } => {
            for (i, quantile) in quantiles_s.iter().enumerate() {
                seconds(&format!("quantiles_s[{i}]"), *quantile);
            }
            let key = format!("{key}.quantiles_s");
            let what = format!("expected at least two quantiles, got {}", quantiles_s.len());
            judge.demand(quantiles_s.len() >= 2, key.as_str(), what);
            for (i, pair) in quantiles_s.windows(2).enumerate() {
                let what =
                    format!("expected a quantile of at least {} s, got {}", pair[0], pair[1]);
                let unordered = pair.iter().any(|quantile| quantile.is_nan());
                judge.demand(pair[0] <= pair[1] || unordered, format!("{key}[{}]", i + 1), what);
            }
            *correlation
        }
    };
    let what = format!("expected a correlation of at least 0 and below 1, got {correlation}");
    judge.demand((0.0..1.0).contains(&correlation), format!("{key}.correlation"), what);
}

fn propagation_mistakes(judge: &mut Judge, key: &str, propagation: &PropagationConfig) {
    let PropagationConfig {
        tx_power_dbm,
        noise_dbm,
        exponent,
        loss_at_1m_db,
        shadowing_sigma_db,
        shadowing_cell_m,
        obstruction_db,
    } = *propagation;
    let powers = [
        ("tx_power_dbm", tx_power_dbm),
        ("noise_dbm", noise_dbm),
        ("loss_at_1m_db", loss_at_1m_db),
    ];
    for (name, value) in powers {
        let what = format!("expected a finite {name}, got {value}");
        judge.demand(value.is_finite(), format!("{key}.{name}"), what);
    }
    judge.amount(format!("{key}.exponent"), "exponent", "", exponent);
    judge.amount(format!("{key}.shadowing_sigma_db"), "deviation", "dB", shadowing_sigma_db);
    judge.amount(format!("{key}.obstruction_db"), "loss", "dB", obstruction_db);
    let what = format!("expected a finite length above 0 m, got {shadowing_cell_m}");
    let holds = shadowing_cell_m > 0.0 && shadowing_cell_m.is_finite();
    judge.demand(holds, format!("{key}.shadowing_cell_m"), what);
}
