//! What the fleet calls cleared, on the raster of the roads.

use csat_clearing::bitmap::Bitmap;
use csat_proto::ids::AgentId;
use csat_world::contamination::Square;
use csat_world::road_area::RoadArea;

/// Which cells of road are called cleared, and by whom first.
pub struct Claims {
    roads: RoadArea,
    /// The road that is not claimed.
    open: RoadArea,
    /// By cell: who claimed it first.
    by: Vec<Option<AgentId>>,
    count: u64,
}

impl Claims {
    /// No claims on these roads.
    pub fn new(roads: &RoadArea) -> Self {
        let by = vec![None; roads.columns() * roads.rows()];
        Self { roads: roads.clone(), open: roads.clone(), by, count: 0 }
    }

    /// How many cells are claimed.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Who claimed a cell first, if it is claimed.
    pub fn claimant(&self, cell: u32) -> Option<AgentId> {
        self.by.get(cell as usize).copied().flatten()
    }

    /// Claims the cells of road whose middle lies in a pixel of `mask`, the pixels of the image over `square`; row 0
    /// is north, column 0 west. Gives the cells that were not claimed before.
    pub fn claim(&mut self, agent: AgentId, square: &Square, mask: &Bitmap) -> Vec<u32> {
        let pixel_m = square.side_m / f64::from(mask.columns());
        let corner = |sign: f64| square.middle.map(|middle| middle + sign * square.side_m / 2.0);
        let corners @ [[west, _], [_, north]] = [corner(-1.0), corner(1.0)];
        let is_claimed = |cell: &u32| {
            let [x, y] = self.roads.middle(*cell);
            let [right, down] = [(x - west) / pixel_m, (north - y) / pixel_m];
            if right < 0.0 || down < 0.0 {
                return false;
            }
            let (right, down) = (right as u16, down as u16);
            down < mask.rows() && right < mask.columns() && mask.get(down, right)
        };
        let new: Vec<u32> = self.open.cells_in(corners).filter(is_claimed).collect();
        for &cell in &new {
            self.open.set(cell, false);
            self.by[cell as usize] = Some(agent);
        }
        self.count += new.len() as u64;
        new
    }

    /// Withdraws the claim on a cell.
    pub fn withdraw(&mut self, cell: u32) {
        if self.by[cell as usize].take().is_some() {
            self.open.set(cell, true);
            self.count -= 1;
        }
    }

    /// Withdraws every claim.
    pub fn withdraw_all(&mut self) {
        if self.count > 0 {
            *self = Self::new(&self.roads);
        }
    }
}
