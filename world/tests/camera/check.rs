//! Compares the renderer with the oracle.

use csat_proto::camera::{CameraView, Pose};
use csat_proto::frame::Label;
use csat_world::camera::oracle::{Hit, Oracle};
use csat_world::camera::{Classified, Renderer};
use csat_world::scene::{Entity, Scene};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Pixels counted over many views.
#[derive(Debug, Default, Clone, Copy)]
pub struct Count {
    pub pixels: usize,
    /// Pixels with a label other than Unknown.
    pub known: usize,
    /// Unknown pixels whose samples all agree.
    pub conservative: usize,
    /// Of these, those that denser sampling does not explain.
    pub unexplained: usize,
}

impl Count {
    pub fn add(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.known += other.known;
        self.conservative += other.conservative;
        self.unexplained += other.unexplained;
    }

    pub fn share(&self, part: usize) -> f64 {
        part as f64 / self.pixels.max(1) as f64
    }
}

/// The thing that, by the renderer, all rays of a pixel meet.
fn claim(seen: &Classified, pixel: usize) -> Option<Hit> {
    let entity = seen.entity(pixel);
    match (seen.labels()[pixel], entity) {
        (Label::Unknown, _) => None,
        (Label::Ground, None) => Some(Hit::Ground),
        (Label::Obstacle, Some(Entity::Obstacle(_))) | (Label::Target, Some(Entity::Target(_))) => {
            entity.map(Hit::Solid)
        }
        (label, entity) => panic!("pixel {pixel}: {label:?} of {entity:?}"),
    }
}

/// One view to be checked.
pub struct Check<'a> {
    pub name: String,
    pub scene: &'a Scene,
    pub oracle: Oracle,
    pub view: CameraView,
    pub pose: Pose,
    columns: usize,
    rows: usize,
}

impl<'a> Check<'a> {
    pub fn new(name: String, scene: &'a Scene, renderer: &Renderer, pose: Pose) -> Self {
        let view = renderer.model().at(&pose);
        let (columns, rows) =
            (usize::from(renderer.model().columns), usize::from(renderer.model().rows));
        Self { name, scene, oracle: Oracle::new(scene), view, pose, columns, rows }
    }

    fn within(&self, c: f64, r: f64, slack: f64) -> Option<Hit> {
        let (hit, distance_m) = self.oracle.cast_image(&self.view, c, r)?;
        (distance_m <= self.view.model().d_max_m * (1.0 + slack)).then_some(hit)
    }

    fn fail(&self, column: usize, row: usize, at: [f64; 2], said: Option<Hit>, met: Option<Hit>) {
        panic!(
            "{}: pixel (row {row}, column {column}) is {said:?}, but the ray of {at:?} meets \
             {met:?}\nmodel {:?}\npose {:?}\nscene {:?}",
            self.name,
            self.view.model(),
            self.pose,
            self.scene
        );
    }

    /// Checks every label against `k + 1` x `k + 1` rays per pixel, borders and corners included, and
    /// counts Unknown pixels without visible cause.
    pub fn grid(&self, seen: &Classified, k: usize) -> Count {
        let width = self.columns * k + 1;
        let step = 1.0 / k as f64;
        let samples: Vec<Option<Hit>> = (0..width * (self.rows * k + 1))
            .map(|i| self.within((i % width) as f64 * step, (i / width) as f64 * step, 1e-9))
            .collect();
        let mut count = Count { pixels: self.columns * self.rows, ..Count::default() };
        for pixel in 0..count.pixels {
            let (row, column) = (pixel / self.columns, pixel % self.columns);
            let said = claim(seen, pixel);
            let first = samples[row * k * width + column * k];
            let mut uniform = first.is_some();
            for i in 0..=k {
                for j in 0..=k {
                    let (sr, sc) = (row * k + i, column * k + j);
                    let met = samples[sr * width + sc];
                    uniform &= met == first;
                    if said.is_some() && met != said {
                        self.fail(column, row, [sc as f64 * step, sr as f64 * step], said, met);
                    }
                }
            }
            count.known += usize::from(said.is_some());
            if said.is_none() && uniform {
                count.conservative += 1;
                count.unexplained += usize::from(!self.is_at_silhouette(column, row));
            }
            if said.is_some() {
                self.check_depth(seen, pixel);
            }
        }
        count
    }

    fn check_depth(&self, seen: &Classified, pixel: usize) {
        let (c, r) = ((pixel % self.columns) as f64 + 0.5, (pixel / self.columns) as f64 + 0.5);
        let (_, distance_m) = self.oracle.cast_image(&self.view, c, r).expect("checked before");
        let rho_m = seen.rho_m(pixel);
        let error = (rho_m - distance_m).abs() / distance_m;
        assert!(error < 1e-6, "{}: rho {rho_m} m, oracle {distance_m} m at {c}, {r}", self.name);
    }

    /// Whether denser rays, or rays just outside, show why a pixel is Unknown: another entity, a
    /// distance beyond d_max, or a jump in depth.
    fn is_at_silhouette(&self, column: usize, row: usize) -> bool {
        const N: usize = 40;
        const RIM: f64 = 1e-3;
        let at = |i: usize| -RIM + (1.0 + 2.0 * RIM) * i as f64 / N as f64;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut common = None;
        for i in 0..=N {
            let mut line = Vec::new();
            for j in 0..=N {
                let (c, r) = (column as f64 + at(j), row as f64 + at(i));
                let Some((hit, distance)) = self.oracle.cast_image(&self.view, c, r) else {
                    return true;
                };
                let too_far = distance > self.view.model().d_max_m * (1.0 - 1e-9);
                if too_far || *common.get_or_insert(hit) != hit {
                    return true;
                }
                line.push(1.0 / distance);
            }
            rows.push(line);
        }
        let jumps = |line: &[f64]| {
            line.windows(4).any(|w| {
                let calm = (w[1] - w[0]).abs().max((w[3] - w[2]).abs());
                (w[2] - w[1]).abs() > 2.0 * calm + 1e-9
            })
        };
        rows.iter().any(|line| jumps(line))
            || (0..=N).any(|j| jumps(&rows.iter().map(|line| line[j]).collect::<Vec<_>>()))
    }

    /// Claims around every edge and vertex of the scene: rays that a grid of samples would miss.
    pub fn edges(&self, seen: &Classified, seed: u64, per_edge: usize) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for prism in &self.scene.prisms {
            for ring in &prism.rings {
                for (i, a) in ring.iter().enumerate() {
                    let b = ring[(i + 1) % ring.len()];
                    for _ in 0..per_edge {
                        let t = match rng.random_range(0..4) {
                            0 => 0.0,
                            1 => 10f64.powf(rng.random_range(-8.0..-1.0)),
                            _ => rng.random_range(0.0..1.0),
                        };
                        let x = a[0] + t * (b[0] - a[0]);
                        let y = a[1] + t * (b[1] - a[1]);
                        for z in [0.0, prism.height_m, rng.random_range(0.0..prism.height_m)] {
                            let z =
                                if t > 0.0 && rng.random_bool(0.5) { prism.height_m } else { z };
                            self.near(seen, &[x, y, z].into(), &mut rng);
                        }
                    }
                }
            }
        }
    }

    /// Claims close to the image of a point.
    fn near(&self, seen: &Classified, p_world: &nalgebra::Vector3<f64>, rng: &mut ChaCha8Rng) {
        let Some([c, r]) = self.view.project(p_world) else { return };
        for _ in 0..3 {
            let radius = 10f64.powf(rng.random_range(-9.0..-0.5));
            let angle = rng.random_range(0.0..std::f64::consts::TAU);
            let (c, r) = (c + radius * angle.cos(), r + radius * angle.sin());
            let (column, row) = (c.floor(), r.floor());
            if column < 0.0 || row < 0.0 {
                continue;
            }
            let (column, row) = (column as usize, row as usize);
            if column >= self.columns || row >= self.rows {
                continue;
            }
            let said = claim(seen, row * self.columns + column);
            if said.is_some() {
                let met = self.within(c, r, 1e-9);
                if met != said {
                    self.fail(column, row, [c, r], said, met);
                }
            }
        }
    }
}
