//! Reading the files of recorded losses that `[netem]` names.

use std::path::Path;

use csat_netem::config::LossConfig;
use csat_netem::trace::{Trace, TraceError};

use super::mistake::Mistake;
use super::model::Scenario;
use super::source::{Site, Source, Sources};
use super::tree;

/// Puts the text of each recording into the scenario in place of its file's name, so that the
/// resolved scenario needs no other file. A recording that cannot be read is a mistake, and that
/// channel loses nothing while the rest is judged.
pub fn resolve(
    scenario: &mut Scenario,
    sources: &mut Sources,
    tree: &tree::Table,
    mistakes: &mut Vec<Mistake>,
) {
    for (name, channel) in scenario.netem.all_channels_mut() {
        // Both together are a mistake that others report.
        let LossConfig::Trace { file: Some(file), lost: None } = &channel.loss else { continue };
        let key = format!("netem.{name}.loss.file");
        let Some(node) = tree::exact(tree, &key) else { continue };
        channel.loss = match read(file, &node.value, sources) {
            Ok(text) => LossConfig::Trace { file: None, lost: Some(text) },
            Err(mistake) => {
                mistakes.push(mistake);
                LossConfig::Iid { p: 0.0 }
            }
        };
    }
}

fn read(file: &str, site: &Site, sources: &mut Sources) -> Result<String, Mistake> {
    let refuse = |text: String, sources: &Sources| {
        Mistake::new(text)
            .expected(
                "a text file of 0 and 1 (relative to the scenario file, or with --set to the \
                 current folder)",
            )
            .at(Some(sources.place(site)))
    };
    let Some(folder) = &sources.get(site.source).folder else {
        return Err(refuse(format!("there is no trace `{file}` in the program"), sources));
    };
    let path =
        if folder.as_os_str() == "." { Path::new(file).to_owned() } else { folder.join(file) };
    let text = std::fs::read_to_string(&path).map_err(|error| {
        refuse(format!("cannot read the trace `{}`: {error}", path.display()), sources)
    })?;
    let (message, span, expected) = match Trace::parse(&text) {
        Ok(_) => return Ok(text),
        Err(TraceError::Character { offset, got, .. }) => {
            let span = offset..offset + got.len_utf8();
            (format!("a trace cannot have {got:?}"), span, "0, 1, white space or a # comment")
        }
        Err(TraceError::Empty) => {
            ("this trace has no message".to_owned(), 0..0, "at least one 0 or 1")
        }
    };
    let name = path.to_string_lossy().into_owned();
    let source = sources.push(Source { name, text, is_file: true, folder: None });
    let place = sources.place(&Site { source, span });
    Err(Mistake::new(message).expected(expected).at(Some(place)))
}
