//! What links do to messages, and what the monitor finds.

use std::collections::BTreeMap;
use std::fmt::Write;

use csat_experiments::plot::canvas::{group, label, round, text};
use csat_experiments::scenario::Loaded;
use csat_experiments::set_membership::{SetMembership, layers as known};
use csat_mission::engine::{Engine, LifeEvent};
use csat_netem::fate::Reason;
use csat_proto::ids::AgentId;
use svg::node::element::{Group, Path};

use super::flight::{Check, Recorded, load};
use super::sheet::{GAP_PX, Sheet, Style};

const WIDTH_PX: f64 = 980.0;
const LEFT_PX: f64 = 90.0;
const ROW_PX: f64 = 24.0;
const TOP_PX: f64 = 44.0;

/// How long the flight with lossy links is, seconds.
const LOSSY_S: f64 = 30.0;
/// What its links do.
const LOSSY: [&str; 5] = [
    "netem.radio.range_m=130",
    "netem.radio.loss={model=\"gilbert-elliott\",p=0.05,r=0.3}",
    "netem.radio.delay={model=\"uniform\",mean_s=0.4,spread_s=0.4}",
    "netem.outage=[{agent=2,from_s=12.0,until_s=19.0,kind=\"crash\"}]",
    "netem.partition=[{groups=[[0,1],[2,3]],from_s=23.0,until_s=27.0}]",
];

/// A time axis of `seconds` above rows.
struct Axis {
    seconds: f64,
}

impl Axis {
    fn x(&self, time_s: f64) -> f64 {
        LEFT_PX + (WIDTH_PX - LEFT_PX - GAP_PX) * time_s / self.seconds
    }

    fn draw(&self, every_s: u32, rows: usize) -> Group {
        let bottom = TOP_PX + ROW_PX * rows as f64;
        let times = (0..=self.seconds as u32).step_by(every_s as usize);
        times.fold(group("axis"), |all, time| {
            let x = round(self.x(f64::from(time)));
            let line = Path::new()
                .set("d", format!("M{x} {TOP_PX}V{bottom}"))
                .set("stroke", "#E3E3E0")
                .set("stroke-width", 1);
            let name = text(x, bottom + 15.0, 11.5, format!("{time} s"));
            all.add(line).add(name.set("text-anchor", "middle"))
        })
    }
}

/// The colour of what became of a message.
fn colour(fate: Option<Reason>) -> &'static str {
    match fate {
        None => known::TARGET_SET,
        Some(Reason::Outage) => "#111111",
        Some(Reason::Partition) => "#CC79A7",
        Some(Reason::Range) => "#0072B2",
        Some(_) => "#D55E00",
    }
}

/// The fate of every message of a short flight with lossy links.
pub fn links() -> String {
    let Loaded { scenario, world, .. } = load(&LOSSY);
    let period_s = scenario.run.period_s;
    let mission = SetMembership::new(&scenario);
    let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
    let axis = Axis { seconds: LOSSY_S };
    let (mut marks, mut lives) = (BTreeMap::<Option<Reason>, String>::new(), Vec::new());
    let count = scenario.agents.count;
    let row = |src: AgentId, dst: AgentId| {
        f64::from(src.0 * (count - 1) + dst.0 - u16::from(dst.0 > src.0))
    };
    for _ in 0..(LOSSY_S / period_s) as u32 {
        let trace = engine.step();
        lives.extend(trace.lives);
        for passage in &trace.passages {
            let sent = &passage.sent;
            let top = TOP_PX + ROW_PX * row(sent.src, sent.dst) + 3.0;
            let x = axis.x(sent.time.seconds());
            let data = marks.entry(passage.fate.first.err()).or_default();
            let (end, bottom) = match passage.fate.first {
                Ok(delivery) => (axis.x(delivery.at.seconds()), top + ROW_PX - 6.0),
                Err(_) => (x, top + 8.0),
            };
            write!(data, "M{x:.1} {top:.0}L{end:.1} {bottom:.0}").expect("text grows");
        }
    }
    let rows = usize::from(count * (count - 1));
    let mut sheet = Sheet::new(WIDTH_PX);
    let title = "What became of each message, by sender and receiver";
    sheet.add(text(GAP_PX, 24.0, 14.0, title).set("font-weight", "bold"), 0.0);
    sheet.add(axis.draw(5, rows), TOP_PX + ROW_PX * rows as f64 + 18.0);
    for (src, dst) in (0..count).flat_map(|src| (0..count).map(move |dst| (src, dst))) {
        if src != dst {
            let y = TOP_PX + ROW_PX * row(AgentId(src), AgentId(dst)) + 16.0;
            sheet.add(text(GAP_PX, y, 12.0, format!("U{src} → U{dst}")), 0.0);
        }
    }
    for (fate, data) in marks {
        let ticks = Path::new().set("d", data).set("fill", "none").set("stroke", colour(fate));
        sheet.add(ticks.set("stroke-width", if fate.is_none() { 1.0 } else { 2.0 }), 0.0);
    }
    for (agent, event) in lives {
        sheet.add(life(&axis, period_s, row(agent, AgentId(0)), event), 0.0);
    }
    let line = |fate| Style::line(colour(fate), 2.0);
    sheet.key(&[
        (line(None), "delivered: from when it was said to when it was heard"),
        (line(Some(Reason::Range)), "lost: range"),
        (line(Some(Reason::Loss)), "random loss"),
        (line(Some(Reason::Outage)), "outage"),
        (line(Some(Reason::Partition)), "partition"),
    ]);
    sheet.finish()
}

/// A life that ends or begins, beside the first row of its agent.
fn life(axis: &Axis, period_s: f64, row: f64, event: LifeEvent) -> Group {
    let (step, words) = match event {
        LifeEvent::Crashed { step, incarnation } => {
            (step, format!("incarnation {} ends", incarnation.0))
        }
        LifeEvent::Restarted { step, incarnation } => {
            (step, format!("incarnation {} begins", incarnation.0))
        }
    };
    let x = round(axis.x(f64::from(step.0) * period_s));
    let y = TOP_PX + ROW_PX * row;
    let line = Path::new()
        .set("d", format!("M{x} {y}v{}", 3.0 * ROW_PX))
        .set("stroke", "#111111")
        .set("stroke-width", 1.5)
        .set("stroke-dasharray", "4 3");
    group("life").add(line).add(label(x, y + 4.0, 12.0, "#111111", words))
}

/// Each car and the set that must contain it, over time.
pub fn guarantee(recorded: &Recorded) -> String {
    let cars = recorded.checks[0].len();
    let seconds = recorded.period_s * (recorded.checks.len() - 1) as f64;
    let axis = Axis { seconds };
    let mut sheet = Sheet::new(WIDTH_PX);
    let title =
        "For each car, the set that agent 0 says it is in: the larger the set, the higher the band";
    sheet.add(text(GAP_PX, 24.0, 14.0, title).set("font-weight", "bold"), 0.0);
    sheet.add(axis.draw(10, cars), TOP_PX + ROW_PX * cars as f64 + 18.0);
    for car in 0..cars {
        let middle = TOP_PX + ROW_PX * (car as f64 + 0.5);
        sheet.add(text(GAP_PX, middle + 4.0, 12.0, format!("car {car}")), 0.0);
        let checks: Vec<Check> = recorded.checks.iter().map(|step| step[car]).collect();
        for (is_identified, fill) in [(false, known::UNEXPLORED), (true, known::TARGET_SET)] {
            let data = band(&axis, recorded.period_s, middle, &checks, |check| {
                check.is_contained && check.is_identified == is_identified
            });
            sheet.add(Path::new().set("d", data).set("fill", fill), 0.0);
        }
        let broken = band(&axis, recorded.period_s, middle, &checks, |check| !check.is_contained);
        sheet.add(Path::new().set("d", broken).set("fill", known::OEM), 0.0);
    }
    let steps = recorded.checks.len();
    let broken = recorded.checks.iter().flatten().filter(|check| !check.is_contained).count();
    let found = format!("outside its set: a violation ({broken} of {} checks)", steps * cars);
    sheet.key(&[
        (Style::fill(known::UNEXPLORED, 1.0), "not identified: in X̄"),
        (Style::fill(known::TARGET_SET, 1.0), "identified: in its own set"),
        (Style::fill(known::OEM, 1.0), &found),
    ]);
    sheet.finish()
}

/// A rectangle for each step of a car that `wanted` accepts; higher for larger sets.
fn band(
    axis: &Axis,
    period_s: f64,
    middle: f64,
    checks: &[Check],
    wanted: impl Fn(&Check) -> bool,
) -> String {
    let mut data = String::new();
    for (step, check) in checks.iter().enumerate().filter(|(_, check)| wanted(check)) {
        let (from, to) = (step as f64 * period_s, (step + 1) as f64 * period_s);
        let (x0, x1) = (axis.x(from), axis.x(to.min(axis.seconds)));
        // The whole region fills the row. Fourth roots, for sets from 10 to 250 000 m² to be seen.
        let half = (check.area_m2.powf(0.25) / 500f64.sqrt()).min(1.0) * (ROW_PX / 2.0 - 2.0);
        write!(data, "M{x0:.1} {:.1}H{x1:.1}V{:.1}H{x0:.1}Z", middle - half, middle + half)
            .expect("text grows");
    }
    data
}
