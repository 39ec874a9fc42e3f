use super::*;

fn read(text: &str) -> Result<NetemConfig, String> {
    toml::from_str(text).map_err(|error| error.message().to_owned())
}

/// Every key of the section.
const FULL: &str = r#"
trace = "all"
[radio]
range_m = 150
mtu_bytes = 1200
corruption = 0.01
duplication = 0.02
light_delay = true
loss = { model = "gilbert-elliott", p = 0.05, r = 0.25 }
delay = { model = "pareto", mean_s = 0.2 }
rate = { bytes_s = 1200, burst_bytes = 600, queue_bytes = 4000 }
[radio.propagation]
exponent = 3
[zeta]
loss = { model = "markov4", p13 = 0.1, p31 = 0.5 }
delay = { model = "table", quantiles_s = [0, 0.1, 0.5], correlation = 0.3 }
[alpha-2]
loss = { model = "trace", lost = "0100110" }
delay = { model = "normal", mean_s = 0.2, sd_s = 0.1 }
[[outage]]
agent = 2
from_s = 60
until_s = 90
kind = "crash"
[[outage]]
agent = 1
from_s = 5
[[partition]]
groups = [[0, 1], [2, 3]]
one_way = true
[[jammer]]
p_m = [250, 250]
radius_m = 50
channel = "zeta"
"#;

#[test]
fn everything_can_be_said_and_written_down_again() {
    let config = read(FULL).unwrap();
    assert_eq!(config.mistakes(4), []);
    assert_eq!(config.channel_names().collect::<Vec<_>>(), ["radio", "alpha-2", "zeta"]);
    assert_eq!(config.channel_id("zeta"), Some(ChannelId(2)));
    assert_eq!(config.channel_id("omega"), None);
    assert_eq!(config.channel(ChannelId(0)), Some(&config.radio));
    assert_eq!(config.channel(ChannelId(1)), config.channels.get("alpha-2"));
    assert_eq!(config.channel(ChannelId(3)), None);
    let crashes: Vec<&OutageConfig> = config.crashes().collect();
    assert_eq!((crashes.len(), crashes[0].agent), (1, 2));
    assert_eq!(config.outage[1].until_s, f64::INFINITY);
    assert_eq!(config.radio.loss, LossConfig::GilbertElliott { p: 0.05, r: 0.25, h: 0.0, k: 1.0 });
    assert_eq!(
        config.channels["zeta"].loss,
        LossConfig::Markov4 { p13: 0.1, p31: 0.5, p32: 0.0, p23: 1.0, p14: 0.0 }
    );
    let written = toml::to_string_pretty(&config).unwrap();
    assert_eq!(read(&written).unwrap(), config, "{written}");
}

#[test]
fn nothing_said_is_a_perfect_radio() {
    let config = read("").unwrap();
    assert_eq!(config, NetemConfig::default());
    assert_eq!(config.mistakes(1), []);
    assert_eq!(config.radio, ChannelConfig::default());
    let written = toml::to_string_pretty(&config).unwrap();
    assert_eq!(read(&written).unwrap(), config);
    let old = "radio = { range_m = 80, loss = { model = 'iid', p = 0.4 }, delay = { model = \
               'constant', mean_s = 1.2 } }";
    assert_eq!(read(old).unwrap().radio.loss, LossConfig::Iid { p: 0.4 });
}

#[test]
fn unknown_keys_are_refused() {
    let keys = "expected one of `radio`, `outage`, `partition`, `jammer`, `trace`";
    for (text, message) in [
        ("Radio = {}", format!("unknown field `Radio`, {keys}")),
        ("outages = [{ agent = 1 }]", format!("unknown field `outages`, {keys}")),
        ("tracing = 'all'", format!("unknown field `tracing`, {keys}")),
        ("seed = 5", format!("unknown field `seed`, {keys}")),
        ("'a b' = {}", format!("unknown field `a b`, {keys}")),
        ("'' = {}", format!("unknown field ``, {keys}")),
    ] {
        assert_eq!(read(text), Err(message));
    }
    for text in [
        "far = { rnage_m = 5 }",
        "radio = { loss = { model = 'iid', p = 0.1, q = 0.1 } }",
        "outage = [{ agent = 1, from_s = 0, when = 5 }]",
        "trace = 'some'",
        "radio = 5",
    ] {
        assert!(read(text).is_err(), "{text}");
    }
}

/// One impossible value each: its key, and a part of the message.
#[test]
fn every_impossible_value_is_found() {
    let cases = [
        ("radio.range_m = -1", "radio.range_m", "at least 0 m (or inf), got -1"),
        ("radio.range_m = nan", "radio.range_m", "got NaN"),
        ("radio.corruption = 1.1", "radio.corruption", "between 0 and 1, got 1.1"),
        ("radio.duplication = -0.1", "radio.duplication", "between 0 and 1, got -0.1"),
        ("radio.rate.bytes_s = 0", "radio.rate.bytes_s", "above 0 bytes/s (or inf), got 0"),
        ("far.rate.bytes_s = nan", "far.rate.bytes_s", "got NaN"),
        ("radio.loss = { model = 'iid', p = nan }", "radio.loss.p", "probability p between 0"),
        (
            "radio.loss = { model = 'gilbert-elliott', p = 0, r = 0 }",
            "radio.loss.p",
            "p + r above 0",
        ),
        ("radio.loss = { model = 'gilbert-elliott', p = 1, r = 2 }", "radio.loss.r", "got 2"),
        ("far.loss = { model = 'gilbert-elliott', p = 1, r = 1, h = -1 }", "far.loss.h", "-1"),
        (
            "radio.loss = { model = 'markov4', p13 = 0.6, p31 = 0.5, p14 = 0.5 }",
            "radio.loss.p13",
            "p13 + p14 of at most 1, got 1.1",
        ),
        (
            "radio.loss = { model = 'markov4', p13 = 0.6, p31 = 0.5, p32 = 0.6 }",
            "radio.loss.p31",
            "p31 + p32 of at most 1, got 1.1",
        ),
        (
            "radio.loss = { model = 'markov4', p13 = 0.6, p31 = 0 }",
            "radio.loss.p31",
            "no burst would ever end",
        ),
        (
            "radio.loss = { model = 'markov4', p13 = 0.6, p31 = 0.5, p32 = 0.1, p23 = 0 }",
            "radio.loss.p23",
            "never left",
        ),
        ("radio.loss = { model = 'trace' }", "radio.loss", "`file` or `lost`"),
        ("radio.loss = { model = 'trace', file = 'x' }", "radio.loss.file", "x was not read"),
        ("radio.loss = { model = 'trace', file = 'x', lost = '1' }", "radio.loss", "got both"),
        ("radio.loss = { model = 'trace', lost = '' }", "radio.loss.lost", "at least one 0 or 1"),
        (
            "radio.loss = { model = 'trace', lost = '01x' }",
            "radio.loss.lost",
            "line 1, column 3: expected 0, 1, white space or a # comment, got 'x'",
        ),
        ("radio.delay = { model = 'constant', mean_s = inf }", "radio.delay.mean_s", "got inf"),
        (
            "radio.delay = { model = 'uniform', mean_s = 1, spread_s = 2 }",
            "radio.delay.spread_s",
            "at most mean_s = 1 s, got 2",
        ),
        (
            "radio.delay = { model = 'normal', mean_s = 1, sd_s = -2 }",
            "radio.delay.sd_s",
            "at least 0 s, got -2",
        ),
        (
            "radio.delay = { model = 'pareto', mean_s = 1, shape = 1 }",
            "radio.delay.shape",
            "shape above 1, got 1",
        ),
        (
            "radio.delay = { model = 'pareto', mean_s = 1e9 }",
            "radio.delay.mean_s",
            "at most 1000000 s, got 1000000000",
        ),
        (
            "radio.delay = { model = 'pareto', mean_s = 1, correlation = 1 }",
            "radio.delay.correlation",
            "below 1, got 1",
        ),
        (
            "radio.delay = { model = 'table', quantiles_s = [1] }",
            "radio.delay.quantiles_s",
            "at least two quantiles, got 1",
        ),
        (
            "radio.delay = { model = 'table', quantiles_s = [1, 3, 2] }",
            "radio.delay.quantiles_s[2]",
            "at least 3 s, got 2",
        ),
        (
            "far.propagation.shadowing_cell_m = 0",
            "far.propagation.shadowing_cell_m",
            "above 0 m, got 0",
        ),
        ("radio.propagation.exponent = -1", "radio.propagation.exponent", "got -1"),
        ("radio.propagation.noise_dbm = nan", "radio.propagation.noise_dbm", "got NaN"),
        (
            "outage = [{ agent = 4, from_s = 0 }]",
            "outage[0].agent",
            "an agent below 4, agents.count and stations, got 4",
        ),
        (
            "outage = [{ agent = 0, from_s = 0 }, { agent = 1, from_s = 5, until_s = 5 }]",
            "outage[1].until_s",
            "after from_s = 5 s (or inf), got 5",
        ),
        ("outage = [{ agent = 0, from_s = -1 }]", "outage[0].from_s", "at least 0 s, got -1"),
        ("outage = [{ agent = 0, from_s = 0, until_s = nan }]", "outage[0].until_s", "got NaN"),
        (
            "outage = [{ agent = 0, from_s = 0, until_s = 9, kind = 'crash' }, \
             { agent = 0, from_s = 8, kind = 'crash' }]",
            "outage[1].from_s",
            "outside outage[0], in which agent 0 is down from 0 s to 9 s, got 8 s to inf s",
        ),
        ("partition = [{ groups = [[0, 1]] }]", "partition[0].groups", "two groups, got 1"),
        ("partition = [{ groups = [[0], []] }]", "partition[0].groups[1]", "got none"),
        ("partition = [{ groups = [[0], [1, 7]] }]", "partition[0].groups[1][1]", "got 7"),
        (
            "partition = [{ groups = [[0, 2], [1, 2]] }]",
            "partition[0].groups[1][1]",
            "once, got 2, which is in group 0 too",
        ),
        ("jammer = [{ p_m = [0, nan], radius_m = 1 }]", "jammer[0].p_m", "finite coordinates"),
        ("jammer = [{ p_m = [0, 0], radius_m = -1 }]", "jammer[0].radius_m", "got -1"),
        ("jammer = [{ p_m = [0, 0], radius_m = 1, loss = 2 }]", "jammer[0].loss", "got 2"),
        (
            "jammer = [{ p_m = [0, 0], radius_m = 1, channel = 'fra' }]",
            "jammer[0].channel",
            "one of the channels radio, got fra",
        ),
    ];
    for (text, key, part) in cases {
        let mistakes = read(text).unwrap().mistakes(4);
        assert_eq!(mistakes.len(), 1, "{text}: {mistakes:?}");
        assert_eq!(mistakes[0].0, key, "{text}");
        assert!(mistakes[0].1.contains(part), "{text}: {}", mistakes[0].1);
    }
}

#[test]
fn what_is_extreme_but_possible_is_allowed() {
    for text in [
        "radio.range_m = inf",
        "radio.rate.bytes_s = inf",
        "radio.loss = { model = 'gilbert-elliott', p = 1, r = 0 }",
        "radio.loss = { model = 'markov4', p13 = 0, p31 = 0 }",
        "radio.delay = { model = 'uniform', mean_s = 1, spread_s = 1 }",
        "outage = [{ agent = 0, from_s = 0, until_s = 9, kind = 'crash' }, \
         { agent = 0, from_s = 9, kind = 'crash' }, { agent = 0, from_s = 1 }]",
        "jammer = [{ p_m = [0, 0], radius_m = inf }]",
    ] {
        assert_eq!(read(text).unwrap().mistakes(4), [], "{text}");
    }
}

#[test]
fn more_channels_than_ids_are_too_many() {
    let channels = |n| (0..n).map(|i| (format!("c{i:03}"), ChannelConfig::default())).collect();
    let config = |n| NetemConfig { channels: channels(n), ..Default::default() };
    assert_eq!(config(255).mistakes(1), []);
    assert_eq!(config(255).channel_id("c254"), Some(ChannelId(255)));
    let mistakes = config(256).mistakes(1);
    assert_eq!(mistakes, [(String::new(), "expected at most 256 channels, got 257".to_owned())]);
}
