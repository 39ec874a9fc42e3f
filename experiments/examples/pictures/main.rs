//! The pictures of docs/concepts, from real data.
//!
//! Usage: `pictures FOLDER`. Flies `city`, seed 1, for two minutes with perfect links, and for half a
//! minute with links that lose messages, and writes nine SVG files.

mod fleet;
mod flight;
mod guidance;
mod knowing;
mod sensing;
mod sheet;

use std::path::{Path, PathBuf};

use flight::Recorded;

/// When pictures are taken, seconds: a multiple of T_MPC, so that guidance decides at that step.
const AT_S: f64 = 66.0;
/// How long cars are watched, seconds.
const UNTIL_S: f64 = 120.0;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).map(PathBuf::from).unwrap_or_else(|| {
        eprintln!("usage: pictures FOLDER");
        std::process::exit(2)
    });
    std::fs::create_dir_all(&folder)?;
    let mut recorded = Recorded::fly(AT_S, UNTIL_S);
    let write = |name: &str, svg: String| write(&folder, name, &svg);
    write("frame", sensing::frame(&recorded))?;
    write("outer-inner", sensing::outer_and_inner(&recorded))?;
    write("sensing", sensing::sensing(&recorded))?;
    write("predict-correct", knowing::predict_and_correct(&recorded))?;
    write("hidden-oem", knowing::hidden_and_oem(&mut recorded))?;
    write("ageing", knowing::ageing(&recorded))?;
    write("guidance", guidance::guidance(&recorded))?;
    write("guarantee", fleet::guarantee(&recorded))?;
    write("links", fleet::links())
}

fn write(folder: &Path, name: &str, svg: &str) -> std::io::Result<()> {
    let path = folder.join(format!("{name}.svg"));
    std::fs::write(&path, svg)?;
    println!("{} ({} kB)", path.display(), svg.len().div_ceil(1000));
    Ok(())
}
