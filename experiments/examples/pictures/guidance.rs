//! A decision of the planner, and its candidates.

use std::f64::consts::PI;

use csat_agent::agent::SetMembershipAgent;
use csat_agent::guidance::{Motion, Planner};
use csat_experiments::plot::canvas::{Panel, group, label, round};
use csat_experiments::plot::{town, uav_colour};
use csat_experiments::set_membership::layers as known;
use csat_mission::picture;
use csat_proto::camera::Pose;
use csat_proto::raster::Raster;
use svg::node::element::{Group, Path};

use super::flight::Recorded;
use super::sheet::{Sheet, Style};

/// A candidate of a decision.
struct Candidate {
    /// Its poses at the ends of the blocks.
    poses: [Pose; 2],
    /// What they would see of X^Δ.
    seen: Raster,
    /// J⁰ + κ·J², m²; J¹ only breaks ties.
    cost_m2: f64,
}

/// A decision: candidates, the one taken, and what it would see.
pub fn guidance(recorded: &Recorded) -> String {
    // Who plans last knows the final plans of all others, and so do we.
    let decider = recorded.agents.len() - 1;
    let agent = &recorded.agents[decider];
    let (colour, chosen) = (uav_colour(decider), agent.planned());
    let candidates = candidates(recorded, decider);
    let gap = |c: &&Candidate| gap_m(&c.poses, chosen);
    let taken = candidates.iter().min_by(|a, b| gap(a).total_cmp(&gap(b))).expect("there are 25");
    let costs = || candidates.iter().map(|c| c.cost_m2);
    let (least, most) = (costs().fold(f64::INFINITY, f64::min), costs().fold(0.0, f64::max));
    assert!(taken.cost_m2 <= least, "the agent chose {} m², {least} is less", taken.cost_m2);
    let footprint = Style::line(colour, 1.4).dashed("6 4");
    let overview = |panel: &Panel| {
        let wanted = picture::cells(&agent.knowledge().planner_rasters().wanted);
        let all = group("decision")
            .add(town::ground(panel, &recorded.view))
            .add(Style::fill(known::UNEXPLORED, 0.85).on(panel.cells(&wanted)))
            .add(SEEN.on(panel.cells(&picture::cells(&taken.seen))))
            .add(town::buildings(panel, &recorded.view));
        let all = chosen.iter().fold(all, |all, pose| {
            let corners = agent.config().camera.at(pose).footprint();
            all.add(footprint.on(panel.area_of([&corners])))
        });
        (0..).zip(&recorded.agents).fold(all, |all, (index, agent)| {
            all.add(plan(panel, index, agent.pose(), agent.planned()))
        })
    };
    let close = |panel: &Panel| {
        let mut sorted: Vec<&Candidate> = candidates.iter().collect();
        sorted.sort_by(|a, b| b.cost_m2.total_cmp(&a.cost_m2));
        let lines = sorted.iter().fold(group("candidates"), |all, candidate| {
            let share = (most - candidate.cost_m2) / (most - least).max(1.0);
            let grey = (220.0 - 200.0 * share) as u8;
            let shade = format!("#{grey:02X}{grey:02X}{grey:02X}");
            all.add(path(panel, agent.pose(), &candidate.poses, 1.8).set("stroke", shade))
        });
        let taken = path(panel, agent.pose(), chosen, 6.0).set("stroke", "#D55E00");
        let labels = [sorted[0], sorted[sorted.len() - 1]].map(|candidate| {
            let [x, y, _] = candidate.poses[1].p_world;
            let [x, y] = panel.pixel([x, y]);
            label(x, y - 5.0, 12.0, "#222222", format!("{:.0} m²", candidate.cost_m2))
        });
        let under = group("close").add(taken.set("stroke-opacity", 0.6)).add(lines);
        let under = under.add(plan(panel, decider, agent.pose(), &[]));
        labels.into_iter().fold(under, |all, label| all.add(label))
    };
    let mut sheet = Sheet::new(980.0);
    let width = sheet.share(2);
    let size = agent.config().ground.size_m.map(|s| s + 30.0);
    let title = "Where cars can be, and what the chosen plan would see of it";
    sheet.window((0, width), title, ([0.0; 2], size), overview);
    let title = format!("The 25 candidates of UAV {decider}, darker when they cost less");
    let [x, y, _] = agent.pose().p_world;
    sheet.window((1, width), &title, ([x, y], [78.0; 2]), close);
    sheet.key(&[
        (Style::fill(known::UNEXPLORED, 0.85), "X^Δ, where cars can be"),
        (SEEN, "what the plan would see of it"),
        (footprint, "its footprints after 3 s and 6 s"),
        (Style::fill("#D55E00", 0.6), "the plan chosen"),
    ]);
    sheet.finish()
}

/// What a plan would see.
const SEEN: Style = Style::fill("#D55E00", 0.75);

/// How far the ends of two plans are from each other, metres.
fn gap_m(a: &[Pose], b: &[Pose]) -> f64 {
    let gap =
        |(a, b): (&Pose, &Pose)| (a.p_world[0] - b.p_world[0]).hypot(a.p_world[1] - b.p_world[1]);
    a.iter().zip(b).map(gap).sum()
}

/// What a pose is expected to see, whatever is wanted there: its footprint without the shadows of
/// the map's boxes (5.23).
fn seen_from(planner: &mut Planner, agent: &SetMembershipAgent, pose: &Pose) -> Raster {
    let mut seen = planner.footprint(pose);
    seen.subtract(&planner.predicted_hidden(&agent.knowledge().oem, None, pose));
    seen
}

/// The heading that a decision began with: the one last commanded, which the vehicle has reached all
/// but exactly.
fn heading_rad(agent: &SetMembershipAgent) -> f64 {
    let turned = |to: f64| ((to - agent.pose().yaw_rad + PI).rem_euclid(2.0 * PI) - PI).abs();
    let increments = agent.config().guidance.increments_deg.iter();
    let headings = increments.map(|degrees| agent.planned()[0].yaw_rad - degrees.to_radians());
    headings.min_by(|a, b| turned(*a).total_cmp(&turned(*b))).unwrap_or_default()
}

/// Every sequence of two increments, and its cost (5.32), worked out apart from the planner.
fn candidates(recorded: &Recorded, decider: usize) -> Vec<Candidate> {
    let agent = &recorded.agents[decider];
    let (config, knowledge) = (agent.config(), agent.knowledge());
    let rasters = knowledge.planner_rasters();
    let (mut planner, motion) = (Planner::new(config), Motion::new(config));
    let others = recorded.agents.iter().enumerate().filter(|(index, _)| *index != decider);
    let mut seen_by_others = vec![Raster::empty(*rasters.wanted.grid()); 2];
    for (_, other) in others {
        for (pose, seen) in other.planned().iter().zip(&mut seen_by_others) {
            seen.union_with(&seen_from(&mut planner, agent, pose));
        }
    }
    // What is left after a block, before and after the own look.
    let growth_m = config.targets.v_max_m_s * config.guidance.period_s;
    let pass_block = |left: &Raster, block: usize| {
        let mut base = left.dilated_disc(growth_m);
        base.subtract(&rasters.margin);
        base.subtract(&seen_by_others[block]);
        base
    };
    let start = Pose { yaw_rad: heading_rad(agent), ..*agent.pose() };
    let first_base = pass_block(&rasters.wanted, 0);
    let mut all = Vec::new();
    for u in &config.guidance.increments_deg {
        let first = motion.advance(&start, u.to_radians());
        let first_seen = seen_from(&mut planner, agent, &first);
        let mut left = first_base.clone();
        left.subtract(&first_seen);
        let second_base = pass_block(&left, 1);
        for v in &config.guidance.increments_deg {
            let second = motion.advance(&first, v.to_radians());
            let mut seen = seen_from(&mut planner, agent, &second);
            let mut left = second_base.clone();
            left.subtract(&seen);
            let hidden = left.count_common(&rasters.hidden_recently);
            let cell_m2 = left.grid().cell_m.powi(2);
            let cost_m2 = left.area_m2() + config.guidance.kappa * f64::from(hidden) * cell_m2;
            seen.union_with(&first_seen);
            seen.intersect_with(&rasters.wanted);
            all.push(Candidate { poses: [first, second], seen, cost_m2 });
        }
    }
    all
}

fn path(panel: &Panel, from: &Pose, poses: &[Pose], width: f64) -> Path {
    let points = std::iter::once(from).chain(poses).map(|p| [p.p_world[0], p.p_world[1]]);
    let points: Vec<[f64; 2]> = points.collect();
    Path::new()
        .set("d", panel.line(&points))
        .set("fill", "none")
        .set("stroke-width", width)
        .set("stroke-linejoin", "round")
        .set("stroke-linecap", "round")
}

/// Where a UAV is and intends to fly.
fn plan(panel: &Panel, index: usize, pose: &Pose, planned: &[Pose]) -> Group {
    let colour = uav_colour(index);
    let [x, y] = panel.pixel([pose.p_world[0], pose.p_world[1]]);
    let dot = Path::new()
        .set("d", format!("M{} {}h8v8h-8Z", round(x - 4.0), round(y - 4.0)))
        .set("fill", colour);
    group("plan").add(path(panel, pose, planned, 3.0).set("stroke", colour)).add(dot).add(label(
        x,
        y - 8.0,
        13.0,
        colour,
        format!("U{index}"),
    ))
}
