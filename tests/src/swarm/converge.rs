//! What a healed core must agree on.

use super::Swarm;
use crate::geometry::difference_m2;

/// How far sets of two agents may be apart: simplifications of up to 0.15 m a step go different ways.
/// A share of the region, and of a target's set.
const UNEXPLORED_SHARE: f64 = 0.01;
const TARGET_SHARE: f64 = 0.1;
/// The least area that the latter is taken of, m².
const TARGET_M2: f64 = 30.0;

/// All of the core know what the first of it knows.
///
/// # Errors
/// What they do not agree on.
pub fn check(engine: &Swarm, core: &[u16]) -> Result<(), String> {
    let knowledge = |i: u16| engine.seats()[usize::from(i)].agent.knowledge();
    let first = knowledge(core[0]);
    for &other in &core[1..] {
        let law = |what: String| Err(format!("UAVs {} and {other} of the core: {what}", core[0]));
        let second = knowledge(other);
        if !first.targets.keys().eq(second.targets.keys()) {
            return law(format!("{:?} and {:?}", first.targets.keys(), second.targets.keys()));
        }
        if first.oem != second.oem {
            let differ = first.oem.cells().iter().zip(second.oem.cells()).filter(|(a, b)| a != b);
            return law(format!("{} cells of the map differ", differ.count()));
        }
        let apart_m2 = difference_m2(first.unexplored.region(), second.unexplored.region());
        if apart_m2 > UNEXPLORED_SHARE * first.ground().area_m2() {
            return law(format!("what is unexplored differs by {apart_m2:.1} m²"));
        }
        for ((j, a), b) in first.targets.iter().zip(second.targets.values()) {
            let (a, b) = (a.region(), b.region());
            let apart_m2 = difference_m2(a, b);
            if apart_m2 > TARGET_SHARE * a.area_m2().max(b.area_m2()).max(TARGET_M2) {
                return law(format!("target {j} differs by {apart_m2:.1} m²"));
            }
        }
    }
    Ok(())
}
