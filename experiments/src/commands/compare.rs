//! `csat compare`.

use csat_experiments::cli::CompareArguments;
use csat_experiments::compare;
use csat_experiments::verdict::DONE;

use super::flight::judge;
use super::say;

/// `csat compare`.
pub fn compare(arguments: &CompareArguments) -> anyhow::Result<u8> {
    judge(print(arguments))
}

fn print(arguments: &CompareArguments) -> anyhow::Result<u8> {
    let comparison = compare::compare(&arguments.a, &arguments.b)?;
    if arguments.json {
        say(&(serde_json::to_string_pretty(&comparison)? + "\n"))?;
    } else {
        say(&comparison.text())?;
    }
    Ok(DONE)
}
