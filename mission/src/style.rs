//! How the layers of a mission are drawn. Every renderer (SVG, browser, Foxglove) takes its colours,
//! its order and its legend from here.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// A name or a colour: constant in a mission, owned when it was read from a file.
pub type Text = Cow<'static, str>;

/// What is always the same about a layer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Style {
    /// The name of the layer and of its document (`view/{i}/{key}`): small letters, digits, `_` and `-`.
    pub key: Text,
    /// What the layer shows, for a legend.
    pub title: Text,
    /// What the layer consists of.
    pub kind: Form,
    /// The colour of the fill, of the hatching, or of the highest value.
    pub colour: Colour,
    /// How areas and cells are filled.
    pub fill: Fill,
    /// The outline of areas.
    pub line: Option<Line>,
    /// The property of an area or a point that is written beside it.
    pub label: Option<Text>,
    /// The boolean property of an area or a point that a live picture marks with ◉.
    pub mark: Option<Text>,
    /// The unit of the values of a heat map.
    pub unit: Option<Text>,
    /// The title of the small map that shows this layer by itself, beside the large one.
    pub panel: Option<Text>,
    /// Whether buildings cover it.
    #[serde(rename = "ground")]
    pub is_ground: bool,
    /// Whether recordings draw it in three dimensions and on a map of the Earth, for each agent.
    #[serde(rename = "scene")]
    pub is_in_scene: bool,
}

/// What a layer consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// [`Content::Areas`](crate::picture::Content::Areas).
    Areas,
    /// [`Content::Cells`](crate::picture::Content::Cells).
    Cells,
    /// [`Content::Heights`](crate::picture::Content::Heights).
    Heights,
    /// [`Content::Heat`](crate::picture::Content::Heat).
    Heat,
    /// [`Content::Points`](crate::picture::Content::Points).
    Points,
}

/// A colour.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Colour {
    /// Always this one: `#RRGGBB`.
    Fixed(Text),
    /// The one of the palette with the index that this property says.
    By(Text),
}

/// How an area is filled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fill {
    /// Not at all.
    None,
    /// With the colour.
    Plain {
        /// From 0 to 1.
        opacity: f64,
    },
    /// With parallel lines at 45°.
    Hatch {
        /// From one line to the next, pixels.
        spacing_px: f64,
        /// Width of a line, pixels.
        width_px: f64,
        /// Whether the lines go down from left to right.
        #[serde(rename = "falling")]
        is_falling: bool,
    },
}

/// An outline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Its colour.
    pub colour: Colour,
    /// Its width, pixels.
    pub width_px: f64,
}

impl Colour {
    /// A constant colour, `#RRGGBB`.
    pub const fn fixed(colour: &'static str) -> Self {
        Self::Fixed(Cow::Borrowed(colour))
    }
}

impl Line {
    /// A line of a constant colour.
    pub const fn fixed(colour: &'static str, width_px: f64) -> Self {
        Self { colour: Colour::fixed(colour), width_px }
    }
}
