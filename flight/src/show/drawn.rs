//! What viewers of the Foxglove family draw of an agent's knowledge: the layers whose styles say so.
//!
//! Several agents are in one picture, so the colour of a layer is the colour of its agent; whether the
//! layer is drawn faintly, and what it consists of, follows from its style.

use csat_mission::picture::{Cells, Content, Layer};
use csat_mission::shape;
use csat_mission::style::Style;

/// How far outlines for viewers may be off, metres: they have a third of the corners then, and look
/// the same. Documents have them all.
const PICTURE_M: f64 = 0.25;
/// Number of bands that heights and values are drawn in.
const BANDS: u16 = 5;

/// A layer and how it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// How it is drawn.
    pub style: &'static Style,
    /// What it consists of.
    pub content: Content,
}

impl Drawn {
    /// The layers that viewers draw, from the bottom up, without the properties that they do not show.
    pub fn of(styles: &'static [Style], layers: &[Layer]) -> Vec<Self> {
        let styles = styles.iter().filter(|style| style.is_in_scene);
        let drawn = styles.filter_map(|style| {
            let content = Layer::of(layers, style)?.content.clone();
            let mut drawn = Self { style, content };
            drawn.forget();
            Some(drawn)
        });
        drawn.collect()
    }

    /// Agents that know the same places know the same here.
    fn forget(&mut self) {
        let is_shown = |key: &String| Some(&**key) == self.style.label.as_deref();
        match &mut self.content {
            Content::Areas(areas) => {
                areas.iter_mut().for_each(|area| area.properties.retain(|key, _| is_shown(key)));
            }
            Content::Points(marks) => {
                marks.iter_mut().for_each(|mark| mark.properties.retain(|key, _| is_shown(key)));
            }
            _ => {}
        }
    }

    /// Leaves out corners that do not show.
    pub fn thin(&mut self) {
        let Content::Areas(areas) = &mut self.content else { return };
        for ring in areas.iter_mut().flat_map(|area| &mut area.shapes).flatten() {
            *ring = shape::thinned(ring, PICTURE_M);
        }
    }

    /// The names of its areas or points, for people: `target 3`.
    pub fn names(&self) -> impl Iterator<Item = String> {
        let layer = Layer { key: self.style.key.to_string(), content: self.content.clone() };
        let label = self.style.label.as_deref();
        let name = |properties: &csat_mission::picture::Properties| {
            let label = label.and_then(|label| Some(format!("{label} {}", properties.get(label)?)));
            label.unwrap_or_else(|| layer.key.clone())
        };
        layer.properties().map(name).collect::<Vec<String>>().into_iter()
    }

    /// Cells, heights and values as cells with their places from 0, exclusive, to 1.
    pub fn bands(&self) -> Vec<(f64, Cells)> {
        let bands = match &self.content {
            Content::Cells(cells) => vec![cells.clone()],
            Content::Heights(oem) => oem.bands(BANDS, oem.highest_dm()),
            Content::Heat(heat) => heat.bands(BANDS),
            Content::Areas(_) | Content::Points(_) => Vec::new(),
        };
        let count = bands.len() as f64;
        (1..).zip(bands).map(|(band, cells)| (f64::from(band) / count, cells)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set_membership::layers::LAYERS;
    use csat_mission::picture::{Area, Heat, Properties};

    fn targets(detected: bool) -> Layer {
        let properties =
            [("target".to_owned(), 3.into()), ("detected".to_owned(), detected.into())];
        let shapes = vec![vec![vec![[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]]]];
        let area = Area { shapes, properties: Properties::from_iter(properties) };
        Layer::new("targets", Content::Areas(vec![area]))
    }

    #[test]
    fn agents_that_know_the_same_places_know_the_same() {
        let unexplored = Layer::new("unexplored", Content::Areas(vec![Area::default()]));
        let obstacles = Layer::new("obstacles", Content::Areas(vec![Area::default()]));
        let one = Drawn::of(LAYERS, &[targets(true), obstacles, unexplored.clone()]);
        let other = Drawn::of(LAYERS, &[unexplored, targets(false)]);
        assert_eq!(one, other);
        let keys: Vec<&str> = one.iter().map(|drawn| &*drawn.style.key).collect();
        assert_eq!(keys, ["unexplored", "targets"]);
        assert_eq!(one[1].names().collect::<Vec<_>>(), ["target 3"]);
        assert_eq!(one[0].names().collect::<Vec<_>>(), ["unexplored"]);
    }

    #[test]
    fn values_are_bands_of_cells() {
        let heat = Heat { columns: 2, maximum: 2.0, values: vec![0.0, 2.0], ..Heat::default() };
        let drawn = Drawn { style: &LAYERS[0], content: Content::Heat(heat) };
        let bands = drawn.bands();
        assert_eq!(bands.len(), 5);
        assert_eq!((bands[4].0, &bands[4].1.runs), (1.0, &vec![[0, 1, 2]]));
    }
}
