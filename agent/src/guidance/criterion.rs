//! What a criterion counts as seen and what it costs (`spec/guidance.md`, thesis §5.2).

use std::sync::Arc;

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::raster::{Grid, Raster};

use super::footprint::Footprint;
use super::looks::Looks;
use super::shadow::{Caster, Towers, hides_point};
use super::views::View;
use crate::config::{AgentConfig, Criterion};
use crate::estimate::oem::Oem;

/// What keeps a part of the footprint from being seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Occlusion {
    /// Nothing (5.8).
    None,
    /// H^CVS of this step, wherever the UAV flies (5.17).
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
    /// J² (5.31): φ of the part of X^Δ at the horizon that was hidden of late, m².
    pub hidden_m2: f64,
}

/// The weights of [`Terms`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    /// λ, per metre against square metres.
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

    /// J⁰ + κ·J² + λ·J¹, m². The first two are whole cells, so candidates that see as much tie
    /// exactly and the distance decides.
    pub(super) fn cost(&self, terms: &Terms) -> f64 {
        terms.remaining_m2 + self.kappa * terms.hidden_m2 + self.lambda * terms.distance_m
    }
}

/// Predicts what a pose would see, as the criterion has it.
#[derive(Debug, Clone)]
pub(super) struct Sight {
    camera: CameraModel,
    grid: Grid,
    criterion: Criterion,
    occlusion: Occlusion,
    towers: Towers,
    caster: Caster,
}

impl Sight {
    pub(super) fn new(config: &AgentConfig) -> Self {
        let grid = config.raster_grid();
        Self {
            camera: config.camera,
            grid,
            criterion: config.guidance.criterion,
            occlusion: match config.guidance.criterion {
                Criterion::Str1
                | Criterion::Str2NoHidden
                | Criterion::Circles
                | Criterion::Lawnmower => Occlusion::None,
                Criterion::Str2 => Occlusion::Now,
                Criterion::Str3 | Criterion::Str4 => Occlusion::Oem,
            },
            towers: Towers::default(),
            caster: Caster::new(&grid, config.camera.d_max_m),
        }
    }

    /// Whether X° is taken out of X^Δ in every block: from (5.18) on.
    pub(super) fn removes_margin(&self) -> bool {
        self.criterion != Criterion::Str1
    }

    /// Takes over the OEM if the criterion reads it.
    pub(super) fn load(&mut self, oem: &Oem) {
        if self.occlusion == Occlusion::Oem {
            self.towers.load(oem);
        }
    }

    /// F(x^u) ∩ X_g of a pose.
    pub(super) fn footprint(&self, pose: &Pose) -> Footprint {
        Footprint::of(&self.camera.at(pose), &self.grid)
    }

    /// F(x^u) ∩ `grown` without what the criterion takes to be hidden. `grown` is that of `looks`, which
    /// are in the world of the OEM; `hidden_now` is the viewer's own H^CVS, if known.
    pub(super) fn look(
        &mut self,
        pose: &Pose,
        hidden_now: Option<&Raster>,
        (looks, grown): (&Looks, &Raster),
    ) -> Arc<View> {
        match self.occlusion {
            Occlusion::Oem => looks.at(pose, || self.view(pose, None, grown)),
            Occlusion::None | Occlusion::Now => Arc::new(self.view(pose, hidden_now, grown)),
        }
    }

    fn view(&mut self, pose: &Pose, hidden_now: Option<&Raster>, grown: &Raster) -> View {
        let footprint = self.footprint(pose);
        if self.occlusion == Occlusion::Oem {
            self.caster.cast(&self.towers, pose.p_world, footprint.corners());
        }
        let hidden = |row: u32, word: usize, bits: u64| match self.occlusion {
            Occlusion::None => 0,
            Occlusion::Now => hidden_now.map_or(0, |hidden| hidden.row(row)[word]),
            Occlusion::Oem => self.caster.hidden_bits(row, word, bits),
        };
        let seen = footprint.words().map(|(row, word, bits)| {
            let bits = bits & grown.row(row)[word];
            (row as i32, word as i32, bits & !hidden(row, word, bits))
        });
        View::of(&self.grid, seen)
    }

    /// H^OEM(x^u) ∩ F(x^u) ∩ X_g (§4.6.4), whatever the criterion.
    pub(super) fn predicted_hidden(&mut self, oem: &Oem, pose: &Pose) -> Raster {
        let footprint = self.footprint(pose);
        self.towers.load(oem);
        self.caster.cast(&self.towers, pose.p_world, footprint.corners());
        let mut hidden = Raster::empty(self.grid);
        for (row, word, bits) in footprint.words() {
            hidden.row_mut(row)[word] |= self.caster.hidden_bits(row, word, bits);
        }
        hidden
    }

    /// J¹ of a last pose: `base` is X^Δ at the horizon before the look from that pose, which sees `seen`.
    ///
    /// What remains of `base` within the footprint is what the pose does not see, so the nearest
    /// part that is not hidden lies outside. When all that remains is hidden, it counts as if it
    /// were not: the UAV has to go there somehow.
    pub(super) fn distance_m(
        &self,
        base: &Raster,
        seen: &View,
        hidden_now: &Raster,
        oem: &Oem,
        pose: &Pose,
    ) -> f64 {
        let [x, y, _] = pose.p_world;
        let footprint = self.footprint(pose);
        let from = footprint.barycentre(&self.grid).unwrap_or([x, y]);
        let in_the_open = |column, row| {
            !footprint.contains(column, row)
                && match self.occlusion {
                    Occlusion::None => true,
                    Occlusion::Now => !hidden_now.get(column, row),
                    Occlusion::Oem => {
                        !hides_point(oem, pose.p_world, self.grid.centre(column, row))
                    }
                }
        };
        nearest_m(base, from, in_the_open)
            .or_else(|| {
                let mut remaining = base.clone();
                seen.take_from(&mut remaining);
                nearest_m(&remaining, from, |_, _| true)
            })
            .unwrap_or(0.0)
    }
}

/// The distance from a point to the nearest centre of the cells of `set` that `accept` (column, row)
/// lets through, metres.
pub(super) fn nearest_m(
    set: &Raster,
    from: [f64; 2],
    mut accept: impl FnMut(u32, u32) -> bool,
) -> Option<f64> {
    let grid = set.grid();
    let [west, south] = grid.origin();
    let cell = |x: f64, origin: f64, count: u32| {
        ((x - origin) / grid.cell_m).floor().clamp(0.0, f64::from(count - 1)) as u32
    };
    let middle = (cell(from[0], west, grid.columns), cell(from[1], south, grid.rows));
    let mut best = f64::INFINITY;
    // Rows from the nearest outwards, up to the first that is as far as the best cell so far.
    for offset in 0..grid.rows {
        let below = middle.1.checked_sub(offset);
        let above = (offset > 0).then_some(middle.1 + offset).filter(|&row| row < grid.rows);
        let mut hopeless = true;
        for row in below.into_iter().chain(above) {
            let row_gap = (grid.centre(0, row)[1] - from[1]).abs();
            if row_gap < best {
                hopeless = false;
                nearest_in_row(set, from, (middle.0, row), &mut best, &mut accept);
            }
        }
        if hopeless {
            break;
        }
    }
    best.is_finite().then_some(best)
}

/// Lowers `best` to the distance of the nearest accepted cell of one row, eastwards from `middle`'s
/// column, then westwards.
fn nearest_in_row(
    set: &Raster,
    from: [f64; 2],
    middle: (u32, u32),
    best: &mut f64,
    accept: &mut impl FnMut(u32, u32) -> bool,
) {
    let (column, row) = middle;
    let words = set.row(row);
    let distance = |column: u32| {
        let centre = set.grid().centre(column, row);
        (centre[0] - from[0]).hypot(centre[1] - from[1])
    };
    let start = column as usize / 64;
    let east_mask = u64::MAX << (column % 64);
    'east: for (index, &word) in words.iter().enumerate().skip(start) {
        let mut bits = if index == start { word & east_mask } else { word };
        while bits != 0 {
            let candidate = index as u32 * 64 + bits.trailing_zeros();
            bits &= bits - 1;
            let d = distance(candidate);
            if d >= *best {
                break 'east;
            }
            if accept(candidate, row) {
                *best = d;
                break 'east;
            }
        }
    }
    for (index, &word) in words.iter().enumerate().take(start + 1).rev() {
        let mut bits = if index == start { word & !east_mask } else { word };
        while bits != 0 {
            let top = 63 - bits.leading_zeros();
            bits &= !(1 << top);
            let candidate = index as u32 * 64 + top;
            let d = distance(candidate);
            if d >= *best {
                return;
            }
            if accept(candidate, row) {
                *best = d;
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use csat_proto::model::Ground;

    use super::*;

    #[test]
    fn the_nearest_cell_is_the_nearest_of_all() {
        let grid = Grid::covering(&Ground { size_m: [300.0, 80.0] }, 2.0);
        let mut set = Raster::empty(grid);
        for i in 0..60u32 {
            set.set(i * 7919 % grid.columns, i * 104_729 % grid.rows);
        }
        let odd = |column: u32, row: u32| (column + row) % 2 == 1;
        for from in [[0.0, 0.0], [-151.0, 3.0], [400.0, -90.0], [17.3, 39.9], [-1.0, 500.0]] {
            let distance = |(column, row): (u32, u32)| {
                let c = grid.centre(column, row);
                (c[0] - from[0]).hypot(c[1] - from[1])
            };
            let of_all = |accept: &dyn Fn(u32, u32) -> bool| {
                set.iter().filter(|&(c, r)| accept(c, r)).map(distance).min_by(f64::total_cmp)
            };
            assert_eq!(nearest_m(&set, from, |_, _| true), of_all(&|_, _| true));
            assert_eq!(nearest_m(&set, from, odd), of_all(&odd));
            assert_eq!(nearest_m(&set, from, |_, _| false), None);
        }
    }
}
