//! Gagliardi et al. 2014, §VI: eight UAVs clear a network of roads.
//!
//! The paper shows one run over a network that is not published, and prints few numbers. So the networks are `csat`'s
//! own, another one for each seed, and the figures are of the first seed.
//!
//! | module | what it does |
//! |---|---|
//! | [`uavs`] | what each UAV did over time |
//! | [`phases`] | the first split, encounter and merge, flown again |
//! | [`figures`] | figures 8 to 10 |
//! | [`tables`] | ours beside theirs |

pub mod figures;
pub mod phases;
pub mod tables;
pub mod uavs;

use super::flown::{Flown, unreadable};
use super::table::Table;
use crate::clearing::Clearing;
use crate::scenario::missions::Offered;
use crate::scenario::{Loaded, Request, load};
use crate::sweep::SweepError;
use crate::view::View;
use phases::Phase;
use uavs::Uav;

/// The missions that were flown.
pub struct Clearings<'a> {
    runs: &'a [Flown],
    /// What each UAV did, by mission.
    uavs: Vec<Vec<Uav>>,
    /// What the figures show, if a mission was flown.
    shown: Option<Shown>,
}

/// The first mission.
struct Shown {
    mission: Clearing,
    /// Roads are as wide as the first one, metres.
    road_width_m: f64,
    /// The centre line of each road and its width, metres.
    roads: Vec<(Vec<[f64; 2]>, f64)>,
    /// Its end.
    view: View,
    phases: Vec<Phase>,
}

impl<'a> Clearings<'a> {
    /// Reads what was flown, and flies the first mission again until it has had all phases.
    ///
    /// # Errors
    /// When a file is missing or not what it should be.
    pub fn read(runs: &'a [Flown]) -> Result<Self, SweepError> {
        let uavs: Result<_, _> = runs.iter().map(uavs::read).collect();
        let shown = runs.first().map(Shown::read).transpose()?;
        Ok(Self { runs, uavs: uavs?, shown })
    }

    /// The tables.
    pub fn tables(&self) -> Vec<Table> {
        tables::all(self)
    }

    /// The figures, as markup.
    pub fn figures(&self) -> String {
        figures::all(self)
    }
}

impl Shown {
    fn read(run: &Flown) -> Result<Self, SweepError> {
        let path = run.folder.join("view.json");
        let text = std::fs::read_to_string(&path).map_err(|e| e.to_string());
        let view = text.and_then(|text| serde_json::from_str(&text).map_err(|e| e.to_string()));
        let view: View = view.map_err(|e| unreadable(path, "the last picture of a run", &e))?;
        let path = run.folder.join("scenario.resolved.toml");
        let scenario = path.to_string_lossy();
        let request = Request { scenario: Some(&scenario), sets: &[], seed: None };
        let loaded: Loaded = load(request).map_err(SweepError::Mistakes)?;
        let mission = Clearing::of(&loaded.scenario);
        let map = loaded.world.map();
        let roads = map.roads.iter().enumerate();
        let roads = roads.map(|(index, road)| (road.clone(), map.road_width_m(index))).collect();
        let road_width_m = map.road_width_m(0);
        let phases = phases::fly(mission.clone(), loaded);
        Ok(Self { mission, road_width_m, roads, view, phases })
    }
}
