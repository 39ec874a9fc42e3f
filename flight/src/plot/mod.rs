//! Pictures of a run: `map.svg`, `metrics.svg`, and maps of what other agents know.
//!
//! | module | what it holds |
//! |---|---|
//! | [`canvas`] | from metres to pixels, and small pieces of SVG |
//! | [`town`] | what maps show of the truth |
//! | [`layers`] | what maps show of an agent's knowledge: layers, as their styles say |
//!
//! These three also draw other maps that look the same, such as those of `examples/pictures`.

mod agents;
mod axes;
pub mod canvas;
mod colours;
mod error;
pub mod layers;
mod legend;
mod map;
mod metrics;
#[cfg(test)]
mod tests;
pub mod town;

use std::path::{Path, PathBuf};

use crate::metrics_file;
use crate::run_folder::{FolderError, PartialFile};
use crate::scenario::missions;
use crate::summary::Summary;
use crate::view::View;

pub use agents::agents_svg;
pub use colours::uav_colour;
pub use error::PlotError;
pub use map::map_svg;
pub use metrics::metrics_svg;

/// Whose knowledge a map shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whose {
    /// One agent's.
    Agent(usize),
    /// Every agent's, side by side.
    All,
}

impl std::str::FromStr for Whose {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => Ok(Self::All),
            _ => text
                .parse()
                .map(Self::Agent)
                .map_err(|_| "expected the index of an agent, or all".into()),
        }
    }
}

/// Draws what an agent knew at the end of a finished run, `map-agent-N.svg`, or all of them,
/// `map-agents.svg`; gives the path.
///
/// # Errors
/// When the folder is not that of a finished run, has no such agent, or the system refuses.
pub fn draw_knowledge(folder: &Path, whose: Whose) -> Result<PathBuf, PlotError> {
    let view: View = read_json(&folder.join("view.json"))?;
    let (name, picture) = match whose {
        Whose::All => ("map-agents.svg".to_owned(), agents_svg(&view)),
        Whose::Agent(agent) if agent < view.agents.len() => {
            (format!("map-agent-{agent}.svg"), map_svg(&view, agent))
        }
        Whose::Agent(got) => {
            return Err(PlotError::NoAgent { got, last: view.agents.len().saturating_sub(1) });
        }
    };
    let path = folder.join(name);
    write(&path, &picture)?;
    Ok(path)
}

/// Draws the pictures of a finished run again; gives their paths.
///
/// # Errors
/// When the folder is not that of a finished run, or the system refuses.
pub fn redraw(folder: &Path) -> Result<[PathBuf; 2], PlotError> {
    let view: View = read_json(&folder.join("view.json"))?;
    let summary: Summary = read_json(&folder.join("summary.json"))?;
    let path = folder.join("metrics.csv");
    let unreadable = |reason: String| PlotError::Read { path: path.clone(), reason };
    let kind = missions::kind(&summary.mission).ok_or_else(|| PlotError::Mission {
        path: folder.join("summary.json"),
        got: summary.mission.clone(),
        known: missions::names(),
    })?;
    let curves = metrics_file::read(&path, kind.columns).map_err(|e| unreadable(e.to_string()))?;
    if curves.fleet.points.is_empty() {
        return Err(PlotError::Read { path, reason: "it has no rows".to_owned() });
    }
    let pictures = [
        (folder.join("map.svg"), map_svg(&view, 0)),
        (folder.join("metrics.svg"), metrics_svg(kind, &summary, &curves)?),
    ];
    for (path, picture) in &pictures {
        write(path, picture)?;
    }
    Ok(pictures.map(|(path, _)| path))
}

fn write(path: &Path, picture: &str) -> Result<(), FolderError> {
    let mut file = PartialFile::create(path.to_owned())?;
    file.write_text(picture)?;
    file.finish()
}

fn read_json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, PlotError> {
    let refuse = |reason: String| PlotError::Read { path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(|e| refuse(e.to_string()))?;
    serde_json::from_str(&text).map_err(|e| refuse(e.to_string()))
}
