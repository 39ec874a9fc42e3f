//! The `csat` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    csat_experiments::main(csat_experiments::missions::SHIPPED)
}
