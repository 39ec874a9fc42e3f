//! What there is to draw of an agent's knowledge: layers, in metres of `world`.

use csat_proto::oem::OemCell;
use csat_proto::raster::{Grid, Raster};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::style::Style;

/// A closed ring; the last point is not repeated.
pub type Ring = Vec<[f64; 2]>;
/// Shapes, each an outer ring and its holes.
pub type Shapes = Vec<Vec<Ring>>;
/// The members of a JSON object.
pub type Properties = Map<String, Value>;

/// A part of what an agent knows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// The key of its [`Style`].
    pub key: String,
    /// What there is to draw.
    #[serde(flatten)]
    pub content: Content,
}

/// What there is to draw of a layer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Content {
    /// Sets.
    Areas(Vec<Area>),
    /// A raster of cells that are set or not.
    Cells(Cells),
    /// An occupancy-elevation map.
    Heights(Oem),
    /// A raster of values.
    Heat(Heat),
    /// Places.
    Points(Vec<Mark>),
}

/// A set.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Area {
    /// Its shapes.
    pub shapes: Shapes,
    /// What is known of it, such as `target` or `area_m2`.
    pub properties: Properties,
}

/// A place.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Mark {
    /// Where it is.
    pub point: [f64; 2],
    /// What is known of it.
    pub properties: Properties,
}

/// A raster.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Cells {
    /// Side of a cell.
    pub cell_m: f64,
    /// South-west corner of cell (0, 0).
    pub origin_m: [f64; 2],
    /// Runs of cells: row, first column, column after the last.
    pub runs: Vec<[u32; 3]>,
}

/// An occupancy-elevation map.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Oem {
    /// Side of a cell.
    pub cell_m: f64,
    /// South-west corner of cell (0, 0).
    pub origin_m: [f64; 2],
    /// Occupied cells: column, row, height in decimetres.
    pub occupied: Vec<(u32, u32, u16)>,
    /// Empty cells.
    pub empty: Cells,
}

/// A value for each cell of a raster. Its unit is that of its [`Style`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Heat {
    /// Side of a cell.
    pub cell_m: f64,
    /// South-west corner of cell (0, 0).
    pub origin_m: [f64; 2],
    /// Number of columns.
    pub columns: u32,
    /// The value that is drawn darkest; the lightest is 0.
    pub maximum: f64,
    /// Values, row by row from the south; finite.
    pub values: Vec<f64>,
}

impl Layer {
    /// The layer of a style.
    pub fn new(key: &str, content: Content) -> Self {
        Self { key: key.to_owned(), content }
    }

    /// The layer of a style among others.
    pub fn of<'a>(layers: &'a [Self], style: &Style) -> Option<&'a Self> {
        layers.iter().find(|layer| layer.key == style.key)
    }

    /// The properties of its areas and points.
    pub fn properties(&self) -> impl Iterator<Item = &Properties> {
        let (areas, points): (&[Area], &[Mark]) = match &self.content {
            Content::Areas(areas) => (areas, &[]),
            Content::Points(points) => (&[], points),
            _ => (&[], &[]),
        };
        let of_points = points.iter().map(|mark| &mark.properties);
        areas.iter().map(|area| &area.properties).chain(of_points)
    }
}

/// The targets that layers name, each once: the property `target` of areas and points.
pub fn targets(layers: &[Layer]) -> std::collections::BTreeSet<u64> {
    layers.iter().flat_map(Layer::properties).filter_map(|p| p.get("target")?.as_u64()).collect()
}

impl Cells {
    /// The cells (column, row) of a raster; those of a row that follow each other become one run.
    pub fn of(cell_m: f64, origin_m: [f64; 2], cells: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut runs: Vec<[u32; 3]> = Vec::new();
        for (column, row) in cells {
            match runs.last_mut() {
                Some([last_row, _, end]) if *last_row == row && *end == column => *end += 1,
                _ => runs.push([row, column, column + 1]),
            }
        }
        Self { cell_m, origin_m, runs }
    }

    /// The runs as rectangles, counter-clockwise.
    pub fn rings(&self) -> impl Iterator<Item = Ring> {
        let at = |column: u32, row: u32| {
            let [x, y] = self.origin_m;
            [x + f64::from(column) * self.cell_m, y + f64::from(row) * self.cell_m]
        };
        self.runs.iter().map(move |&[row, from, to]| {
            let above = row.saturating_add(1);
            vec![at(from, row), at(to, row), at(to, above), at(from, above)]
        })
    }
}

impl Oem {
    /// The occupied cells by bands of equal height up to `highest_dm`, the lowest first.
    pub fn bands(&self, count: u16, highest_dm: u16) -> Vec<Cells> {
        let of_height = |height_dm: u16| {
            let band = u32::from(height_dm) * u32::from(count) / (u32::from(highest_dm) + 1);
            band.min(u32::from(count) - 1) as usize
        };
        let mut bands = self.empty_bands(count);
        for &(column, row, height_dm) in &self.occupied {
            bands[of_height(height_dm)].runs.push([row, column, column + 1]);
        }
        bands
    }

    /// The height of the highest cell, at least 1 dm.
    pub fn highest_dm(&self) -> u16 {
        self.occupied.iter().map(|cell| cell.2).max().unwrap_or(1).max(1)
    }

    fn empty_bands(&self, count: u16) -> Vec<Cells> {
        let none = Cells { cell_m: self.cell_m, origin_m: self.origin_m, runs: Vec::new() };
        vec![none; usize::from(count)]
    }
}

impl Heat {
    /// The cells by bands of equal width up to the maximum, the lowest first. A value of 0 and what is
    /// no number are in none.
    pub fn bands(&self, count: u16) -> Vec<Cells> {
        let band_of = |value: f64| {
            let end = (value / self.maximum * f64::from(count)).ceil().min(f64::from(count));
            (value > 0.0).then(|| (end as u16).saturating_sub(1))
        };
        let columns = self.columns.max(1);
        let at = |index: usize| (index as u32 % columns, index as u32 / columns);
        let of_band = |band: u16| {
            let values = self.values.iter().enumerate();
            let cells = values.filter(move |(_, value)| band_of(**value) == Some(band));
            Cells::of(self.cell_m, self.origin_m, cells.map(|(index, _)| at(index)))
        };
        (0..count).map(of_band).collect()
    }
}

/// The members of a JSON object; none of any other value.
pub fn properties(value: Value) -> Properties {
    if let Value::Object(members) = value { members } else { Properties::default() }
}

/// A length to the nearest millimetre.
pub fn to_millimetre(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}

/// A raster as runs.
pub fn cells(raster: &Raster) -> Cells {
    let grid = raster.grid();
    Cells::of(grid.cell_m, grid.origin(), raster.iter())
}

/// An OEM from the states of its cells in row-major order.
pub fn oem(grid: &Grid, states: &[OemCell]) -> Oem {
    let place = |index: usize| (index as u32 % grid.columns, index as u32 / grid.columns);
    let of = |wanted: fn(&OemCell) -> bool| {
        states.iter().enumerate().filter(move |(_, s)| wanted(s)).map(move |(i, _)| place(i))
    };
    let occupied = states.iter().enumerate().filter_map(|(i, state)| match state {
        OemCell::Occupied { height_dm } => Some((place(i).0, place(i).1, *height_dm)),
        _ => None,
    });
    Oem {
        cell_m: grid.cell_m,
        origin_m: grid.origin(),
        occupied: occupied.collect(),
        empty: Cells::of(grid.cell_m, grid.origin(), of(|s| *s == OemCell::Empty)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::model::Ground;

    #[test]
    fn rasters_and_oems_become_runs() {
        let grid = Grid::covering(&Ground { size_m: [20.0, 10.0] }, 5.0);
        let mut raster = Raster::empty(grid);
        raster.set_run(0, 1..4);
        raster.set(0, 1);
        assert_eq!(cells(&raster).runs, [[0, 1, 4], [1, 0, 1]]);
        let mut states = vec![OemCell::Unexplored; 8];
        states[2] = OemCell::Empty;
        states[3] = OemCell::Empty;
        states[4] = OemCell::Occupied { height_dm: 123 };
        let oem = oem(&grid, &states);
        assert_eq!(oem.occupied, [(0, 1, 123)]);
        assert_eq!(oem.empty.runs, [[0, 2, 4]]);
        assert_eq!(oem.origin_m, [-10.0, -5.0]);
        let bands = oem.bands(5, oem.highest_dm());
        assert_eq!(bands.iter().map(|band| band.runs.len()).collect::<Vec<_>>(), [0, 0, 0, 0, 1]);
    }

    #[test]
    fn heat_is_drawn_in_bands() {
        let values = vec![0.0, 0.1, 0.5, f64::NAN, 1.0, 3.0];
        let heat = Heat { cell_m: 2.0, origin_m: [0.0; 2], columns: 3, maximum: 1.0, values };
        let bands = heat.bands(2);
        assert_eq!(bands[0].runs, [[0, 1, 3]]);
        assert_eq!(bands[1].runs, [[1, 1, 3]]);
    }

    #[test]
    fn layers_are_json_with_their_content_beside_their_key() {
        let properties = Properties::from_iter([("target".to_owned(), 3.into())]);
        let layers = [
            Layer::new("cars", Content::Points(vec![Mark { point: [1.0, 2.5], properties }])),
            Layer::new("belief", Content::Heat(Heat::default())),
        ];
        let text = serde_json::to_string(&layers).unwrap();
        let points = r#"[{"key":"cars","points":[{"point":[1.0,2.5],"properties":{"target":3}}]},"#;
        assert!(text.starts_with(points), "{text}");
        assert_eq!(serde_json::from_str::<Vec<Layer>>(&text).unwrap(), layers);
        assert_eq!(targets(&layers), [3].into());
    }
}
