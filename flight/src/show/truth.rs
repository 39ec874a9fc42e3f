//! What the world's process shows people: what is true, and what the fleet is worth.

use csat_proto::ids::{AgentId, TargetId};
use csat_proto::model::Station;
use csat_proto::time::Step;
use csat_world::world::World;
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::flight::Moment;
use crate::scenario::Scenario;
use crate::series::Point;
use crate::view::Building;
use csat_mission::documents::{Document, micro};
use csat_mission::engine::{LifeEvent, StepTrace};
use csat_mission::measures::{Column, Curve, Of};
use csat_mission::mission::{Kind, Mission, Whole};
use csat_mission::picture::Ring;
use csat_mission::picture::to_millimetre;
use csat_mission::shape;
use csat_mission::style::Style;

/// The name of the town's document.
pub const TOWN: &str = "truth/town";
/// The name of the document of what is measured.
pub const COLUMNS: &str = "truth/columns";

/// The name of the document of layers.
pub const LAYERS: &str = "truth/layers";

/// `truth/layers`: how the layers of what agents know are drawn.
pub fn layers(styles: &[Style]) -> Document {
    Document::json(LAYERS, &json!({ "layers": styles }))
}

/// Members of the town's collection beside its features.
#[derive(Debug, Serialize)]
struct TownHead<'a> {
    size_m: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    center: Option<[f64; 2]>,
    scenario: &'a str,
    seed: u64,
    agents: u16,
    stations: &'a [Station],
    targets: u16,
    duration_s: f64,
    period_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    attribution: Option<&'a str>,
}

/// `truth/town`: the town of the scenario called `name`.
pub fn town(name: &str, scenario: &Scenario, world: &World) -> Document {
    let buildings = world.obstacles().iter().flat_map(Building::of).map(|building| {
        let properties = json!({ "kind": "building", "height_m": building.height_m });
        shape::feature(shape::polygon(&building.rings), properties)
    });
    let roads = world.roads().edges().iter().map(|edge| {
        shape::feature(shape::line_string(&rounded(&edge.line)), json!({ "kind": "road" }))
    });
    let map = world.map();
    let head = TownHead {
        size_m: scenario.map.size_m,
        center: map.centre_deg,
        scenario: name,
        seed: scenario.seed,
        agents: scenario.agents.count,
        stations: &scenario.stations,
        targets: scenario.targets.count,
        duration_s: scenario.run.duration_s,
        period_s: scenario.run.period_s,
        attribution: map.attribution.as_deref(),
    };
    Document::geojson(TOWN, shape::collection(buildings.chain(roads).collect(), &head))
}

/// A line to the nearest millimetre.
pub(super) fn rounded(line: &[[f64; 2]]) -> Ring {
    line.iter().map(|p| p.map(to_millimetre)).collect()
}

/// `truth/targets`.
#[derive(Debug, Serialize)]
struct Targets {
    step: Step,
    time_s: f64,
    targets: Vec<Located>,
}

#[derive(Debug, Serialize)]
struct Located {
    target: TargetId,
    location: [f64; 2],
}

/// `truth/targets`: where the cars are.
pub fn targets<M: Mission>(moment: &Moment<'_, M>) -> Document {
    let located = moment.world.targets().iter().enumerate().map(|(index, target)| Located {
        target: TargetId(index as u16),
        location: target.location.map(to_millimetre),
    });
    let (step, time_s) = (moment.trace.step, moment.time_s);
    Document::json("truth/targets", &Targets { step, time_s, targets: located.collect() })
}

/// `truth/metrics`: the mission's values, averaged over its UAVs. What is not defined is not there.
#[derive(Debug, Serialize)]
struct Metrics {
    step: Step,
    time_s: f64,
    #[serde(flatten)]
    values: Map<String, Value>,
    violations: u64,
    bytes_sent: u64,
    alive: Vec<bool>,
    late: Vec<bool>,
}

/// `truth/metrics`: one point of the curves.
pub fn metrics<M: Mission>(moment: &Moment<'_, M>) -> Document {
    let columns = Whole::<M>::KIND.columns;
    let point = Point::of(columns, moment.rows);
    let values = columns.iter().filter_map(|column| {
        let value = point.as_ref()?.get(columns, column.key)?;
        Some((column.key.to_owned(), number(column, value)))
    });
    let alive = moment.trace.alive.clone();
    let mut late = alive.clone();
    for agent in &moment.trace.flown {
        late[usize::from(agent.agent.0)] &= agent.report.is_none();
    }
    let metrics = Metrics {
        step: moment.trace.step,
        time_s: moment.time_s,
        values: values.collect(),
        violations: moment.violations,
        bytes_sent: moment.trace.flown.iter().map(|flown| flown.bytes_sent).sum(),
        alive,
        late,
    };
    Document::json("truth/metrics", &metrics)
}

/// A count of the fleet is a whole number; a mean over agents is not.
fn number(column: &Column, value: f64) -> Value {
    if column.is_count && column.of == Of::Fleet {
        json!(value as u64)
    } else {
        json!(micro(value))
    }
}

/// `truth/columns`: what the numbers of `truth/metrics` and of `view/{i}/stats` are, and which curves to draw.
pub fn columns(kind: &Kind) -> Document {
    let column = |c: &Column| {
        json!({
            "key": c.key,
            "name": c.name,
            "unit": c.unit,
            "of": if c.of == Of::Fleet { "fleet" } else { "agent" },
            "meaning": c.meaning,
        })
    };
    let curve = |c: &Curve| json!({ "key": c.column, "name": c.name, "colour": c.colour });
    let panels = kind.panels.iter().filter_map(|panel| {
        let [least, greatest] = panel.axis;
        Some(json!({
            "title": panel.live?,
            "unit": panel.unit,
            "top": (least == greatest).then_some(greatest),
            "curves": panel.curves.iter().map(curve).collect::<Vec<_>>(),
        }))
    });
    let body = json!({
        "mission": kind.name,
        "headline": kind.headline,
        "columns": kind.columns.iter().map(column).collect::<Vec<_>>(),
        "panels": panels.collect::<Vec<_>>(),
    });
    Document::json(COLUMNS, &body)
}

/// `truth/lives`.
#[derive(Debug, Serialize)]
struct Life<'a> {
    agent: AgentId,
    #[serde(flatten)]
    event: &'a LifeEvent,
    time_s: f64,
}

/// `truth/lives`: a document for each life that ended or began in this step.
pub fn lives<M: Mission>(trace: &StepTrace<M>, time_s: f64) -> Vec<Document> {
    let document = |(agent, event): &(AgentId, LifeEvent)| {
        Document::json("truth/lives", &Life { agent: *agent, event, time_s })
    };
    trace.lives.iter().map(document).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set_membership::SetMembership;
    use crate::testing::small_mission;
    use csat_mission::engine::Engine;

    /// In real time an agent may tell too late: that does not make it dead.
    #[test]
    fn who_tells_late_is_alive() {
        let loaded = small_mission(1.0);
        let mission = SetMembership::new(&loaded.scenario);
        let (netem, seed) = (&loaded.scenario.netem, loaded.scenario.seed);
        let mut engine = Engine::new(mission, loaded.world, netem, seed);
        let mut trace = engine.step();
        trace.flown[1].report = None;
        let said = |trace: &StepTrace<SetMembership>| {
            let moment =
                Moment { time_s: 0.0, world: engine.world(), trace, rows: &[], violations: 0 };
            let body: serde_json::Value = serde_json::from_str(&metrics(&moment).body).unwrap();
            (body["alive"].clone(), body["late"].clone())
        };
        assert_eq!(said(&trace), (json!([true, true]), json!([false, true])));
        trace.alive[1] = false;
        assert_eq!(said(&trace), (json!([true, false]), json!([false, false])));
    }
}
