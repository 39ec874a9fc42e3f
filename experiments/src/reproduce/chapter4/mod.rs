//! Thesis §4.7 and A.1.4: what one frame says of five cars, and of a few buildings.
//!
//! A UAV at (0, 0, 50) looks east. Only the depth noise differs between looks. There is no mission
//! and no prior knowledge: the sets are those of one frame.
//!
//! | module | what it does |
//! |---|---|
//! | [`scene`] | what there is to see |
//! | [`look`] | from a frame to the sets of its cars |
//! | [`settings`] | what differs between the figures |
//! | [`figures`], [`tables`] | ours beside theirs |

pub mod figures;
pub mod look;
pub mod scene;
pub mod settings;
pub mod tables;

use csat_proto::ids::{AgentId, Incarnation};

use super::table::{Table, banner_of};
use crate::report::page;
use crate::scenario::Scenario;
use crate::set_membership::SetMembership;
use csat_mission::mission::Mission;
use look::Looks;
use settings::{Family, Setting, families};

/// Everything that was seen.
#[derive(Debug, Clone)]
pub struct Chapter4 {
    /// How many looks were taken of each setting.
    pub seeds: usize,
    /// What differs, figure by figure; the first one is [`settings::headings`].
    pub families: Vec<(Family, Vec<Looks>)>,
    /// (4.50) of each look at the buildings, per cent.
    pub oem_iou_pct: Vec<f64>,
}

impl Chapter4 {
    /// Looks once per seed with the camera, the cars and the estimator of `scenario`.
    pub fn look(scenario: &Scenario, seeds: &[u64]) -> Self {
        let mission = SetMembership::new(scenario);
        let agent = mission.agent(AgentId(0), Incarnation(0));
        let mut seen: Vec<(Setting, Looks)> = Vec::new();
        let mut looks = |setting: &Setting| {
            let same = |other: &Setting| Setting { name: setting.name.clone(), ..other.clone() };
            let known = seen.iter().find(|(other, _)| same(other) == *setting);
            known.map(|(_, looks)| looks.clone()).unwrap_or_else(|| {
                let looks = Looks::take(setting, seeds);
                seen.push((setting.clone(), looks.clone()));
                looks
            })
        };
        let all = families(agent.config()).into_iter().map(|family| {
            let all = family.settings.iter().map(&mut looks).collect();
            (family, all)
        });
        let families = all.collect();
        let oem_iou_pct = seeds.iter().filter_map(|&seed| scene::oem_iou_pct(&mission, seed));
        Self { seeds: seeds.len(), families, oem_iou_pct: oem_iou_pct.collect() }
    }

    /// The setting of figures 4.9-4.12: cars crosswise, all else as the scenario says.
    pub fn plain(&self) -> &Looks {
        &self.families[0].1[0]
    }

    /// The tables.
    pub fn tables(&self) -> Vec<Table> {
        tables::tables(self)
    }

    /// The page with these tables; `again` is the command that makes it again.
    pub fn html(&self, tables: &[Table], again: &str) -> String {
        let about = page::definitions(&[
            (
                "scene",
                "UAV at (0, 0, 50) m, yaw 0; cars at x = 60, 90, 120, 150 and 180 m".to_owned(),
            ),
            ("looks", format!("{} per setting, which differ in the depth noise", self.seeds)),
            ("again", format!("<code>{}</code>", crate::report::shapes::escaped(again))),
        ]);
        let banner = banner_of(tables);
        let tables: String = tables.iter().map(Table::html).collect();
        page::document(
            "Thesis chapter 4, ours beside theirs",
            &(banner + &about + &tables + &figures::all(self)),
        )
    }
}
