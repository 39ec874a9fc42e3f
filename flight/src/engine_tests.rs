use std::collections::VecDeque;
use std::convert::Infallible;

use crate::set_membership::judge::GUARANTEE;

use crate::set_membership::SetMembership;
use crate::set_membership::report::Report;
use crate::testing::small_mission;
use csat_mission::engine::{Engine, MAX_TRUTHS};
use csat_mission::fleet::Frames;
use csat_mission::fleet::{Brief, Fleet, Flown};
use csat_mission::local::LocalFleet;
use csat_mission::mission::Detail;
use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::LinkId;

/// A fleet whose reports come some steps late, as those of a slow process do in real time.
struct Late {
    fleet: LocalFleet<SetMembership>,
    /// By step, what each agent is yet to tell.
    untold: VecDeque<Vec<Option<Report>>>,
    steps: usize,
}

impl Fleet<SetMembership> for Late {
    type Error = Infallible;

    fn attendance(&mut self) -> Vec<Option<u64>> {
        self.fleet.attendance()
    }

    fn fly(&mut self, brief: &Brief) -> Result<Vec<Flown<SetMembership>>, Infallible> {
        let mut flown = self.fleet.fly(brief)?;
        self.untold.push_back(flown.iter_mut().map(|agent| agent.report.take()).collect());
        if self.untold.len() > self.steps
            && let Some(told) = self.untold.pop_front()
        {
            flown.iter_mut().zip(told).for_each(|(agent, report)| agent.report = report);
        }
        Ok(flown)
    }

    fn show(&mut self) -> Vec<Option<Report>> {
        self.fleet.show()
    }

    fn counters(&self) -> Counters {
        self.fleet.counters()
    }

    fn per_link(&self) -> Vec<(LinkId, LinkCounters)> {
        self.fleet.per_link()
    }

    fn frames(&self) -> Vec<Frames> {
        self.fleet.frames()
    }

    fn has_misidentified(&self) -> Vec<bool> {
        self.fleet.has_misidentified()
    }
}

/// How many checks of the guarantee were made, and how many reports were not checked, in `steps` steps of
/// a mission of two agents and two targets whose reports come `late` steps late.
fn checked(late: usize, steps: usize) -> (u64, u64) {
    let loaded = small_mission(100.0);
    let mission = SetMembership::new(&loaded.scenario);
    let (netem, seed) = (&loaded.scenario.netem, loaded.scenario.seed);
    let fleet = LocalFleet::new(mission.clone(), 2, netem, seed, None);
    let fleet = Late { fleet, untold: VecDeque::new(), steps: late };
    let mut engine = Engine::with_fleet(mission, loaded.world, fleet, netem, seed);
    for _ in 0..steps {
        let Ok(_) = engine.try_step(Detail::Brief);
    }
    assert_eq!(engine.checked().total().violations, 0);
    (engine.checked().of(GUARANTEE).checks, engine.unchecked())
}

#[test]
fn late_reports_are_checked_or_counted_as_unchecked() {
    assert_eq!(checked(0, 10), (10 * 2 * 2, 0));
    // Those of the last three steps are never told.
    assert_eq!(checked(3, 10), (7 * 2 * 2, 0));
    let kept = MAX_TRUTHS - 1;
    assert_eq!(checked(kept, kept + 2), (2 * 2 * 2, 0));
    assert_eq!(checked(kept + 1, kept + 4), (0, 3 * 2));
}
