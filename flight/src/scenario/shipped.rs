//! Scenarios and maps inside the program, so that it works from any folder.

/// A shipped scenario.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    /// What `csat run` calls it.
    pub name: &'static str,
    /// Its TOML.
    pub text: &'static str,
}

impl Shipped {
    /// What it is, in a sentence: the first comment of its text.
    pub fn summary(&self) -> String {
        let comment = self.text.lines().take_while(|line| line.starts_with('#'));
        let text: Vec<&str> = comment.map(|line| line.trim_start_matches('#').trim()).collect();
        let text = text.join(" ");
        text.split(". ").next().unwrap_or_default().trim_end_matches('.').to_owned()
    }
}

/// Every shipped scenario; the first is the default.
pub const SCENARIOS: [Shipped; 9] = [
    Shipped { name: "city", text: include_str!("../../../experiments/scenarios/city.toml") },
    Shipped {
        name: "city-range100",
        text: include_str!("../../../experiments/scenarios/city-range100.toml"),
    },
    Shipped {
        name: "city-bursty",
        text: include_str!("../../../experiments/scenarios/city-bursty.toml"),
    },
    Shipped {
        name: "city-slow",
        text: include_str!("../../../experiments/scenarios/city-slow.toml"),
    },
    Shipped {
        name: "city-storm",
        text: include_str!("../../../experiments/scenarios/city-storm.toml"),
    },
    Shipped {
        name: "helsinki-05",
        text: include_str!("../../../experiments/scenarios/helsinki-05.toml"),
    },
    Shipped {
        name: "helsinki-17",
        text: include_str!("../../../experiments/scenarios/helsinki-17.toml"),
    },
    Shipped {
        name: "clearing",
        text: include_str!("../../../experiments/scenarios/clearing.toml"),
    },
    Shipped { name: "tisdale", text: include_str!("../../../experiments/scenarios/tisdale.toml") },
];

const MAPS: [(&str, &str); 2] = [
    ("helsinki-05.geojson", include_str!("../../../experiments/maps/helsinki-05.geojson")),
    ("helsinki-17.geojson", include_str!("../../../experiments/maps/helsinki-17.geojson")),
];

/// What `map.file` begins with when it names a map inside the program.
pub const PREFIX: &str = "shipped:";

/// The shipped scenario of this name.
pub fn scenario(name: &str) -> Option<Shipped> {
    SCENARIOS.into_iter().find(|s| s.name == name)
}

/// The text of a shipped map.
pub fn map(name: &str) -> Option<&'static str> {
    MAPS.into_iter().find(|(n, _)| *n == name).map(|(_, text)| text)
}

/// The names of all shipped scenarios.
pub fn scenario_names() -> impl Iterator<Item = &'static str> {
    SCENARIOS.into_iter().map(|s| s.name)
}

/// What the command line says of its argument for a scenario.
pub fn scenario_help() -> String {
    let names: Vec<&str> = scenario_names().collect();
    format!(
        "A shipped scenario ({}) or a TOML file [default: {}]",
        names.join(", "),
        SCENARIOS[0].name
    )
}

/// The names of all shipped maps.
pub fn map_names() -> impl Iterator<Item = &'static str> {
    MAPS.into_iter().map(|(name, _)| name)
}
