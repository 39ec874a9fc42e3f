//! Walls that stand in the way of no link: a loss behind buildings that was asked for and never occurs.

use csat_world::world::World;

use super::mistake::Mistake;
use super::model::Scenario;
use super::source::Sources;
use super::tree;

/// A warning for each radio whose `obstruction_db` the user wrote though no building can come between
/// two antennas: there are no ground stations, and every UAV flies above every roof.
pub fn warnings(
    scenario: &Scenario,
    world: &World,
    sources: &Sources,
    tree: &tree::Table,
) -> Vec<Mistake> {
    let highest_m = world.obstacles().iter().map(|o| o.height_m).reduce(f64::max);
    let lowest_m = world.poses().iter().map(|p| p.p_world[2]).fold(f64::INFINITY, f64::min);
    let why = match highest_m {
        None => "there are no buildings".to_owned(),
        Some(roof_m) if roof_m < lowest_m => format!(
            "there are no ground stations, and the highest building, {roof_m} m, is below the lowest \
             UAV, {lowest_m} m"
        ),
        Some(_) => return Vec::new(),
    };
    let warning = |name: &str| {
        let key = format!("netem.{name}.propagation.obstruction_db");
        let node = tree::exact(tree, &key)?;
        let text = format!("`{key}` can have no effect: {why}");
        let help = "walls stand between UAVs and `stations = [{ x_m = 0, y_m = 0, z_m = 2 }]`";
        Some(Mistake::new(text).help(help).at(Some(sources.place(&node.value))))
    };
    let loses = |db: f64| db != 0.0;
    let radios = scenario.netem.all_channels();
    let walled =
        radios.filter(|(_, radio)| radio.propagation.is_some_and(|p| loses(p.obstruction_db)));
    walled.filter_map(|(name, _)| warning(name)).collect()
}
