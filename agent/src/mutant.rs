//! Known mistakes, to prove that the tests would notice them.
//!
//! Each is a line that somebody could have written instead of the right one. With the feature
//! `mutants`, which only `csat-tests` asks for, one of them can be switched on for the whole process;
//! without it `is_on` is `false` at compile time.

/// A known mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Mutant {
    /// What others knew long ago is taken as if it were of now.
    LateSnapshotNotDilated = 1,
    /// X̄ of others is taken without their identified list.
    UnexploredWithoutIdentified,
    /// Another's exclusion is applied without its detection.
    ExclusionWithoutDetection,
    /// A target's own exclusion is taken from its own set.
    ExclusionOfItself,
    /// Detections meet X̄ only after the exclusions were taken from it.
    DetectionAfterExclusion,
    /// Clear ground of long ago is dilated instead of eroded.
    ClearGroundDilated,
    /// Clear ground of long ago is taken as if it were of now.
    ClearGroundNotEroded,
    /// Detections of long ago are taken as if they were of now.
    DetectionNotDilated,
    /// Exclusions of long ago are taken as if they were of now.
    ExclusionNotEroded,
    /// Targets are thought to stand still.
    NoPrediction,
    /// Outer sets are rounded inward to fit a budget.
    OuterShrunkForBudget,
    /// Inner sets are rounded outward to fit a budget.
    InnerGrownForBudget,
    /// Outer sets are simplified inward to keep within their vertices.
    OuterShrunkForVertices,
    /// Inner sets are simplified outward to keep within their vertices.
    InnerGrownForVertices,
    /// The map takes over whatever was said last.
    OemLastWriter,
    /// An earlier life of an agent is still believed.
    StaleIncarnationAccepted,
    /// A new life numbers its messages as the one before did.
    SequenceReused,
    /// An agent claims to hold whatever others claim to hold.
    ClaimsWhatOthersHold,
    /// Nobody is sent what it lacks.
    NeverRepairs,
    /// Blocks of the map that differ are never said again.
    MapNeverRepaired,
    /// A number heard once is heard for all lives.
    RepeatsOfOtherLivesIgnored,
    /// After missed frames sets are grown for one period too few.
    GapOnePeriodShort,
    /// For missed frames the sets of targets are grown, and X̄ is not.
    GapGrowsTargetsOnly,
    /// A target seen first was in X̄ as it was a period ago.
    FirstSeenNotDilated,
    /// Facts are aged as if all clocks were one.
    ClockSkewOfFactsIgnored,
    /// The same for what others knew.
    ClockSkewOfSnapshotsIgnored,
    /// The polygon that stands for what a target may do in a period lies within the disc.
    ReachInscribed,
    /// Airspace that was not seen to be free is flown through.
    UnseenAirspaceFree,
    /// A UAV flies on without knowing a way out.
    NoWayOutNeeded,
    /// The monitor allows a target to be a metre outside of its set.
    MonitorLenient,
}

impl Mutant {
    /// All of them.
    pub const ALL: [Self; 30] = [
        Self::LateSnapshotNotDilated,
        Self::UnexploredWithoutIdentified,
        Self::ExclusionWithoutDetection,
        Self::ExclusionOfItself,
        Self::DetectionAfterExclusion,
        Self::ClearGroundDilated,
        Self::ClearGroundNotEroded,
        Self::DetectionNotDilated,
        Self::ExclusionNotEroded,
        Self::NoPrediction,
        Self::OuterShrunkForBudget,
        Self::InnerGrownForBudget,
        Self::OuterShrunkForVertices,
        Self::InnerGrownForVertices,
        Self::OemLastWriter,
        Self::StaleIncarnationAccepted,
        Self::SequenceReused,
        Self::ClaimsWhatOthersHold,
        Self::NeverRepairs,
        Self::MapNeverRepaired,
        Self::RepeatsOfOtherLivesIgnored,
        Self::GapOnePeriodShort,
        Self::GapGrowsTargetsOnly,
        Self::FirstSeenNotDilated,
        Self::ClockSkewOfFactsIgnored,
        Self::ClockSkewOfSnapshotsIgnored,
        Self::ReachInscribed,
        Self::UnseenAirspaceFree,
        Self::NoWayOutNeeded,
        Self::MonitorLenient,
    ];
}

#[cfg(feature = "mutants")]
static ACTIVE: std::sync::atomic::AtomicU8 = std::sync::atomic::AtomicU8::new(0);

/// Makes the whole process make this mistake, or none.
#[cfg(feature = "mutants")]
pub fn switch(mutant: Option<Mutant>) {
    ACTIVE.store(mutant.map_or(0, |mutant| mutant as u8), std::sync::atomic::Ordering::SeqCst);
}

/// Whether to make this mistake.
#[cfg(feature = "mutants")]
pub fn is_on(mutant: Mutant) -> bool {
    ACTIVE.load(std::sync::atomic::Ordering::Relaxed) == mutant as u8
}

/// Whether to make this mistake.
#[cfg(not(feature = "mutants"))]
pub const fn is_on(_: Mutant) -> bool {
    false
}
