//! What people get to see of an agent of the set-membership mission (docs/topics.md).

use std::collections::BTreeMap;

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::model::Ground;
use serde::Serialize;
use serde_json::json;

use super::measures::percent_of;
use super::report::Report;
use csat_mission::documents::{AgentStep, Document, Headed, micro};
use csat_mission::picture::Cells;
use csat_mission::picture::Knowledge;
use csat_mission::picture::Oem;
use csat_mission::picture::to_millimetre;
use csat_mission::shape;

/// `pose`.
#[derive(Debug, Serialize)]
struct PoseBody {
    #[serde(flatten)]
    pose: Stance,
    footprint: Vec<[f64; 2]>,
}

/// `plan`.
#[derive(Debug, Serialize)]
struct PlanBody {
    poses: Vec<Stance>,
}

/// Where an agent is or will be.
#[derive(Debug, Serialize)]
struct Stance {
    p_world: [f64; 3],
    yaw_rad: f64,
}

impl From<&Pose> for Stance {
    fn from(pose: &Pose) -> Self {
        Self { p_world: pose.p_world.map(to_millimetre), yaw_rad: micro(pose.yaw_rad) }
    }
}

/// `stats`.
#[derive(Debug, Serialize)]
struct StatsBody<'a> {
    identified: usize,
    unexplored_pct: f64,
    hidden_pct: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    oem_iou_pct: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    news_age_s: Option<f64>,
    vertices: u32,
    bytes_sent: u64,
    rejected: &'a BTreeMap<String, u64>,
    withheld: u64,
}

/// Everything but `links`. `hidden` and `oem` only where the report has its maps.
pub(super) fn documents(
    camera: Option<&CameraModel>,
    ground: &Ground,
    step: &AgentStep<'_, Report>,
    known: &Knowledge,
) -> Vec<Document> {
    let mut documents = vec![
        pose(camera, step),
        targets(step, known),
        unexplored(ground, step, known),
        obstacles(step, known),
        plan(step),
        stats(ground, step),
    ];
    if step.report.maps.is_some() {
        documents.push(hidden(step, &known.hidden));
        documents.push(oem(step, &known.oem));
    }
    documents
}

/// A document with the head of its step.
fn headed(step: &AgentStep<'_, Report>, name: &str, body: impl Serialize) -> Document {
    Document::json(step.topic(name), &Headed { head: step.head(), body })
}

fn pose(camera: Option<&CameraModel>, step: &AgentStep<'_, Report>) -> Document {
    let pose = &step.report.pose;
    let footprint = camera.map_or_else(Vec::new, |camera| camera.at(pose).footprint());
    let footprint = footprint.into_iter().map(|p| p.map(to_millimetre)).collect();
    headed(step, "pose", PoseBody { pose: pose.into(), footprint })
}

fn targets(step: &AgentStep<'_, Report>, known: &Knowledge) -> Document {
    let report = step.report;
    let features = report.targets.iter().zip(&known.targets).map(|((target, set), (_, shapes))| {
        let properties = json!({
            "kind": "target",
            "target": target,
            "detected": report.detected.contains(target),
            "area_m2": to_millimetre(set.area_m2()),
        });
        shape::feature(shape::multi_polygon(shapes), properties)
    });
    let body = shape::collection(features.collect(), &step.head());
    Document::geojson(step.topic("targets"), body)
}

fn unexplored(ground: &Ground, step: &AgentStep<'_, Report>, known: &Knowledge) -> Document {
    let area_m2 = step.report.unexplored.area_m2();
    let properties = json!({
        "kind": "unexplored",
        "area_m2": to_millimetre(area_m2),
        "share_pct": micro(percent_of(ground, area_m2)),
    });
    let feature = shape::feature(shape::multi_polygon(&known.unexplored), properties);
    let body = shape::collection(vec![feature], &step.head());
    Document::geojson(step.topic("unexplored"), body)
}

fn obstacles(step: &AgentStep<'_, Report>, known: &Knowledge) -> Document {
    let area_m2 = to_millimetre(step.report.obstacle_margin.area_m2());
    let properties = json!({ "kind": "obstacles", "area_m2": area_m2 });
    let feature = shape::feature(shape::multi_polygon(&known.obstacle_margin), properties);
    let body = shape::collection(vec![feature], &step.head());
    Document::geojson(step.topic("obstacles"), body)
}

fn plan(step: &AgentStep<'_, Report>) -> Document {
    headed(step, "plan", PlanBody { poses: step.report.planned.iter().map(Stance::from).collect() })
}

fn stats(ground: &Ground, step: &AgentStep<'_, Report>) -> Document {
    let report = step.report;
    let body = StatsBody {
        identified: report.targets.len(),
        unexplored_pct: micro(percent_of(ground, report.unexplored.area_m2())),
        hidden_pct: micro(report.hidden_pct),
        oem_iou_pct: report.oem_iou_pct.map(micro),
        news_age_s: report.news_age_s.map(micro),
        vertices: report.vertices(),
        bytes_sent: step.bytes_sent,
        rejected: &report.tally.rejected,
        withheld: report.tally.withheld,
    };
    headed(step, "stats", body)
}

fn hidden(step: &AgentStep<'_, Report>, cells: &Cells) -> Document {
    headed(step, "hidden", cells)
}

fn oem(step: &AgentStep<'_, Report>, oem: &Oem) -> Document {
    headed(step, "oem", oem)
}
