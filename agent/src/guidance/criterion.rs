//! What counts as seen by a criterion, and its cost (docs/concepts/guidance.md, thesis §5.2).

use std::sync::Arc;

use csat_proto::camera::{CameraModel, Pose, PoseError};
use csat_proto::raster::{Grid, Raster};

use super::footprint::Footprint;
use super::nearest::nearest_m;
use super::rounded_views::VisibleCells;
use super::shadow::{OccupiedCells, ShadowCaster, hides_point};
use super::view_cache::ViewCache;
use crate::config::{AgentConfig, Criterion};
use crate::estimate::oem::Oem;
use crate::sense::pose_box::PoseBox;

/// What hides a part of the footprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Occlusion {
    /// Nothing (5.8).
    None,
    /// H^CVS of this step, for every predicted pose (5.17).
    Now,
    /// H^OEM of the predicted pose (5.23).
    Oem,
}

/// The three terms of a cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Terms {
    /// J⁰ (5.6): φ of the predicted X^Δ at the horizon, m².
    pub remaining_m2: f64,
    /// J¹ (5.15), (5.20), (5.26): from the barycentre of the last predicted footprint to the nearest
    /// part of X^Δ that is not hidden, m; 0 when nothing remains.
    pub distance_m: f64,
    /// J² (5.31): φ of the part of X^Δ at the horizon that was recently hidden, m².
    pub hidden_m2: f64,
}

/// The weights of [`Terms`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    /// λ, m² per metre.
    lambda: f64,
    /// κ; 0 unless the criterion is (5.32).
    kappa: f64,
}

impl Weights {
    pub(super) fn new(config: &AgentConfig) -> Self {
        let guidance = &config.guidance;
        let kappa = if guidance.criterion == Criterion::Str3 { guidance.kappa } else { 0.0 };
        Self { lambda: guidance.lambda.max(0.0), kappa }
    }

    /// J⁰ + κ·J² + λ·J¹, m². The first two are whole cells, so candidates that see equal areas have
    /// exactly equal terms, and the distance decides.
    pub(super) fn cost(&self, terms: &Terms) -> f64 {
        terms.remaining_m2 + self.kappa * terms.hidden_m2 + self.lambda * terms.distance_m
    }
}

/// Predicts what a pose would see by the criterion.
#[derive(Debug, Clone)]
pub(super) struct VisibilityModel {
    camera: CameraModel,
    pose_error: PoseError,
    grid: Grid,
    criterion: Criterion,
    occlusion: Occlusion,
    caster: ShadowCaster,
}

/// What a decision looks with: the views that are known, and what the others are made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight<'a> {
    /// The views that are known.
    pub(super) views: &'a ViewCache,
    /// The cells that X^Δ may cover within the horizon.
    pub(super) grown: &'a Raster,
    /// The cells of the map that hide ground, if the criterion reads it.
    pub(super) occupied: Option<&'a OccupiedCells>,
}

impl VisibilityModel {
    pub(super) fn new(config: &AgentConfig) -> Self {
        let grid = config.raster_grid();
        Self {
            camera: config.planning_camera(),
            pose_error: config.pose_error,
            grid,
            criterion: config.guidance.criterion,
            occlusion: match config.guidance.criterion {
                Criterion::Str1
                | Criterion::Str2NoHidden
                | Criterion::Circles
                | Criterion::Lawnmower => Occlusion::None,
                Criterion::Str2 => Occlusion::Now,
                Criterion::Str3 | Criterion::Str4 | Criterion::Str5 => Occlusion::Oem,
            },
            caster: ShadowCaster::new(&grid, config.planning_camera().d_max_m),
        }
    }

    /// See [`super::PlannerInput::pose_error`].
    pub(super) fn expect(&mut self, error: &PoseError) {
        self.pose_error = *error;
    }

    /// Whether X° is taken out of X^Δ in every block: from (5.18) on.
    pub(super) fn removes_margin(&self) -> bool {
        self.criterion != Criterion::Str1
    }

    /// What a decision with `oem` looks with. `views` are those of `oem`, and `grow` finds the cells that X^Δ may cover
    /// within the horizon.
    pub(super) fn sight<'a>(
        &self,
        views: &'a ViewCache,
        oem: &Oem,
        grow: impl FnOnce() -> Raster,
    ) -> Sight<'a> {
        let occupied = (self.occlusion == Occlusion::Oem).then(|| views.occupied(oem));
        Sight { views, grown: views.grown(grow), occupied }
    }

    /// F(x^u) ∩ X_g of a pose.
    pub(super) fn footprint(&self, pose: &Pose) -> Footprint {
        let view = self.camera.at(pose);
        Footprint::of(&view, &PoseBox::new(&view, pose, &self.pose_error), &self.grid)
    }

    /// F(x^u) ∩ `grown` without what is hidden by the criterion; `hidden_now` is the H^CVS of the UAV that
    /// looks, if known.
    pub(super) fn look(
        &mut self,
        pose: &Pose,
        hidden_now: Option<&Raster>,
        sight: &Sight<'_>,
    ) -> Arc<VisibleCells> {
        match self.occlusion {
            Occlusion::Oem => sight.views.at(pose, || self.view(pose, None, sight)),
            Occlusion::None | Occlusion::Now => Arc::new(self.view(pose, hidden_now, sight)),
        }
    }

    fn view(
        &mut self,
        pose: &Pose,
        hidden_now: Option<&Raster>,
        sight: &Sight<'_>,
    ) -> VisibleCells {
        let footprint = self.footprint(pose);
        if let Some(occupied) = sight.occupied {
            self.caster.cast(occupied, pose.p_world, footprint.corners());
        }
        let hidden = |row: u32, word: usize, bits: u64| match self.occlusion {
            Occlusion::None => 0,
            Occlusion::Now => hidden_now.map_or(0, |hidden| hidden.row(row)[word]),
            Occlusion::Oem => self.caster.hidden_bits(row, word, bits),
        };
        let seen = footprint.words().map(|(row, word, bits)| {
            let bits = bits & sight.grown.row(row)[word];
            (row as i32, word as i32, bits & !hidden(row, word, bits))
        });
        VisibleCells::of(&self.grid, seen)
    }

    /// H^OEM(x^u) ∩ F(x^u) ∩ X_g (§4.6.4), for every criterion.
    pub(super) fn predicted_hidden(&mut self, occupied: &OccupiedCells, pose: &Pose) -> Raster {
        let footprint = self.footprint(pose);
        self.caster.cast(occupied, pose.p_world, footprint.corners());
        let mut hidden = Raster::empty(self.grid);
        for (row, word, bits) in footprint.words() {
            hidden.row_mut(row)[word] |= self.caster.hidden_bits(row, word, bits);
        }
        hidden
    }

    /// J¹ of a last pose: `base` is X^Δ at the horizon before the look from that pose, which sees
    /// `seen`.
    ///
    /// The part of `base` that remains within the footprint is not seen from the pose, so the nearest
    /// part that is not hidden lies outside the footprint. When all of the rest is hidden, the
    /// distance is to the nearest hidden part, because the UAV has to fly there.
    pub(super) fn distance_m(
        &self,
        base: &Raster,
        seen: &VisibleCells,
        hidden_now: &Raster,
        oem: &Oem,
        pose: &Pose,
    ) -> f64 {
        let [x, y, _] = pose.p_world;
        let footprint = self.footprint(pose);
        let from = footprint.barycentre(&self.grid).unwrap_or([x, y]);
        let in_the_open = |column, row| match self.occlusion {
            Occlusion::None => true,
            Occlusion::Now => !hidden_now.get(column, row),
            Occlusion::Oem => !hides_point(oem, pose.p_world, self.grid.centre(column, row)),
        };
        nearest_m(base, from, |row| footprint.columns(row), in_the_open)
            .or_else(|| {
                let mut remaining = base.clone();
                seen.take_from(&mut remaining);
                nearest_m(&remaining, from, |_| 0..0, |_, _| true)
            })
            .unwrap_or(0.0)
    }
}
