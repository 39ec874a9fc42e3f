//! The nearest face at the centre of each pixel.

/// Depth buffer over pixel centres, row-major.
#[derive(Debug, Clone, Default)]
pub(super) struct DepthBuffer {
    rows: usize,
    /// Column coordinate of every column's centre.
    centres: Vec<f64>,
    /// 1/z of the nearest face, z along the optical axis, 1/m; 0 where there is no face.
    pub inv_z: Vec<f64>,
    /// Number of the nearest face.
    pub face: Vec<u32>,
    crossings: Vec<f64>,
}

impl DepthBuffer {
    pub fn new(columns: usize, rows: usize) -> Self {
        let pixels = columns * rows;
        Self {
            rows,
            centres: (0..columns).map(|column| column as f64 + 0.5).collect(),
            inv_z: vec![0.0; pixels],
            face: vec![0; pixels],
            crossings: Vec::new(),
        }
    }

    /// Clears the buffer to face 0, the plane 1/z = g · (c, r, 1), everywhere below its horizon.
    pub fn clear(&mut self, [g0, g1, g2]: [f64; 3]) {
        self.face.fill(0);
        for (row, line) in self.inv_z.chunks_exact_mut(self.centres.len().max(1)).enumerate() {
            let base = g1 * (row as f64 + 0.5) + g2;
            for (inv_z, c) in line.iter_mut().zip(&self.centres) {
                *inv_z = (g0 * c + base).max(0.0);
            }
        }
    }

    /// Draws the polygon with these image edges (even-odd rule) on the plane 1/z = g · (c, r, 1),
    /// 1/z being kept within `range` of the polygon's vertices.
    ///
    /// Polygons that share an edge leave no centre between them uncovered: the crossing of an edge
    /// with a row does not depend on the edge's direction.
    pub fn fill(&mut self, edges: &[[[f64; 2]; 2]], g: [f64; 3], range: [f64; 2], face: u32) {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for edge in edges {
            low = low.min(edge[0][1]);
            high = high.max(edge[0][1]);
        }
        for row in first_centre(low, self.rows)..first_centre(high, self.rows) {
            let y = row as f64 + 0.5;
            self.crossings.clear();
            self.crossings.extend(edges.iter().filter_map(|edge| crossing(edge, y)));
            self.crossings.sort_unstable_by(f64::total_cmp);
            for pair in 0..self.crossings.len() / 2 {
                let from = first_centre(self.crossings[2 * pair], self.centres.len());
                let to = first_centre(self.crossings[2 * pair + 1], self.centres.len());
                if from < to {
                    self.span(row, from, to, g, range, face);
                }
            }
        }
    }

    fn span(
        &mut self,
        row: usize,
        from: usize,
        to: usize,
        [g0, g1, g2]: [f64; 3],
        [low, high]: [f64; 2],
        face: u32,
    ) {
        let base = g1 * (row as f64 + 0.5) + g2;
        let start = row * self.centres.len();
        let depths = &mut self.inv_z[start + from..start + to];
        let faces = &mut self.face[start + from..start + to];
        // There is no branch, so that the loop runs in SIMD lanes.
        for ((depth, winner), c) in depths.iter_mut().zip(faces).zip(&self.centres[from..to]) {
            let inv_z = (g0 * c + base).max(low).min(high);
            let nearer = inv_z > *depth;
            *depth = if nearer { inv_z } else { *depth };
            *winner = if nearer { face } else { *winner };
        }
    }
}

/// The first index whose centre is at or after `x`, at most `count`.
fn first_centre(x: f64, count: usize) -> usize {
    // The cast saturates.
    ((x - 0.5).ceil() as usize).min(count)
}

/// The column coordinate where an edge crosses row coordinate `y`.
fn crossing(&[a, b]: &[[f64; 2]; 2], y: f64) -> Option<f64> {
    if (a[1] <= y) == (b[1] <= y) {
        return None;
    }
    let (low, high) = if a[1] <= y { (a, b) } else { (b, a) };
    Some(low[0] + (y - low[1]) / (high[1] - low[1]) * (high[0] - low[0]))
}
