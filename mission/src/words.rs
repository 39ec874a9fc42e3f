//! Words for people.

/// A number of things: `1 car`, `2 cars`.
pub fn counted(count: usize, thing: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {thing}{plural}")
}

/// Agents by name, where there are `uavs` UAVs: `UAV 3`, `UAVs 0, 1 and station 4`.
pub fn named(agents: impl IntoIterator<Item = u16>, uavs: u16) -> String {
    let (flying, standing): (Vec<u16>, Vec<u16>) =
        agents.into_iter().partition(|agent| *agent < uavs);
    let listed = |(kind, ids): (&str, Vec<u16>)| {
        let plural = if ids.len() == 1 { "" } else { "s" };
        let ids: Vec<String> = ids.iter().map(ToString::to_string).collect();
        (!ids.is_empty()).then(|| format!("{kind}{plural} {}", ids.join(", ")))
    };
    let all = [("UAV", flying), ("station", standing)].into_iter().filter_map(listed);
    all.collect::<Vec<_>>().join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stations_are_named_after_the_uavs() {
        assert_eq!(named([3], 4), "UAV 3");
        assert_eq!(named([0, 1], 4), "UAVs 0, 1");
        assert_eq!(named([4], 4), "station 4");
        assert_eq!(named([0, 5, 4], 4), "UAV 0 and stations 5, 4");
    }
}
