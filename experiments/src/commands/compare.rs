//! `csat compare`.

use crate::cli::CompareArguments;
use crate::compare;
use crate::verdict::DONE;

use super::common::say;
use super::runs::judge;

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
