//! `census`: the `csat` command with one mission more.

use std::process::ExitCode;

use csat_census::Census;
use csat_experiments::missions::{Entry, Missions};
use csat_experiments::set_membership::SetMembership;

/// What this program flies. The set-membership mission stays: `census run city` is `csat run city`.
const MISSIONS: Missions = &[&Entry::<Census>::new(), &Entry::<SetMembership>::new()];

fn main() -> ExitCode {
    csat_experiments::main(MISSIONS)
}
