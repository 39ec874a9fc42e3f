//! Known mistakes, to prove that the tests detect them.
//!
//! Each mistake is a plausible wrong line in place of the right one. With the feature `mutants`,
//! which only `csat-tests` enables, one of them can be switched on for the whole process. Without the
//! feature `is_on` is `false` at compile time.

/// A known mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Mutant {
    /// Old knowledge of other agents is taken for current knowledge.
    LateSnapshotNotDilated = 1,
    /// X̄ of another agent is applied without its list of identified targets.
    UnexploredWithoutIdentified,
    /// The exclusion of another agent is applied without its detection.
    ExclusionWithoutDetection,
    /// A target's own exclusion is taken from its own set.
    ExclusionOfItself,
    /// Detections meet X̄ only after the exclusions were taken from it.
    DetectionAfterExclusion,
    /// Old clear ground is dilated instead of eroded.
    ClearGroundDilated,
    /// Old clear ground is taken for current clear ground.
    ClearGroundNotEroded,
    /// Old detections are taken for current ones.
    DetectionNotDilated,
    /// Old exclusions are taken for current ones.
    ExclusionNotEroded,
    /// Targets are assumed to stand still.
    NoPrediction,
    /// Outer sets are rounded inward to fit a budget.
    OuterShrunkForBudget,
    /// Inner sets are rounded outward to fit a budget.
    InnerGrownForBudget,
    /// Outer sets are simplified inward to keep within their vertices.
    OuterShrunkForVertices,
    /// Inner sets are simplified outward to keep within their vertices.
    InnerGrownForVertices,
    /// The map takes the state that arrived last.
    OemLastWriter,
    /// Messages of an earlier incarnation of an agent are still believed.
    StaleIncarnationAccepted,
    /// A new incarnation numbers its messages as the one before.
    SequenceReused,
    /// An agent claims to hold all facts that other agents claim to hold.
    ClaimsWhatOthersHold,
    /// Agents that are missing facts are sent none.
    NeverRepairs,
    /// Blocks of the map that differ are never said again.
    MapNeverRepaired,
    /// A fact number that was applied once counts as applied for all incarnations.
    RepeatsOfOtherIncarnationsIgnored,
    /// After missed frames sets are grown for one period too few.
    GapOnePeriodShort,
    /// For missed frames the sets of targets are grown, and X̄ is not.
    GapGrowsTargetsOnly,
    /// A target seen first is sought in the X̄ of a period ago.
    FirstSeenNotDilated,
    /// Facts are aged as if all clocks were one.
    ClockSkewOfFactsIgnored,
    /// The same for the knowledge of other agents.
    ClockSkewOfSnapshotsIgnored,
    /// The polygon for the motion of a target in a period lies within the disc.
    ReachInscribed,
    /// UAVs fly through airspace that was not seen to be free.
    UnseenAirspaceFree,
    /// A UAV flies on without knowing a way out.
    NoWayOutNeeded,
    /// The reported pose is taken for the true one.
    NominalPoseUsed,
    /// Ground that is clear from some pose of the box is taken for clear.
    ClearFromSomePose,
    /// A target is sought where the reported pose has it only.
    TargetFromOnePose,
    /// Obstacle margins are taken from the reported pose only.
    MarginFromOnePose,
    /// The box of a pose is taken to be no larger than that of a position fix.
    BoxNotGrownBetweenFixes,
    /// The monitor allows a target to be a metre outside of its set.
    MonitorLenient,
    /// What a single agent claims is believed, as if none could lie.
    ClaimsBelievedAtOnce,
    /// The facts and the snapshots of an agent count as claims of two agents.
    OriginCountedTwice,
    /// The claims of an agent that was proven to lie are still counted.
    NamedLiarBelieved,
    /// Of an agent that was proven to lie, messages are still applied.
    NamedLiarHeard,
    /// An agent is taken for a liar if it merely knows less.
    DoubtIsProof,
}

impl Mutant {
    /// All of them.
    pub const ALL: [Self; 40] = [
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
        Self::RepeatsOfOtherIncarnationsIgnored,
        Self::GapOnePeriodShort,
        Self::GapGrowsTargetsOnly,
        Self::FirstSeenNotDilated,
        Self::ClockSkewOfFactsIgnored,
        Self::ClockSkewOfSnapshotsIgnored,
        Self::ReachInscribed,
        Self::UnseenAirspaceFree,
        Self::NoWayOutNeeded,
        Self::NominalPoseUsed,
        Self::ClearFromSomePose,
        Self::TargetFromOnePose,
        Self::MarginFromOnePose,
        Self::BoxNotGrownBetweenFixes,
        Self::MonitorLenient,
        Self::ClaimsBelievedAtOnce,
        Self::OriginCountedTwice,
        Self::NamedLiarBelieved,
        Self::NamedLiarHeard,
        Self::DoubtIsProof,
    ];
}

#[cfg(feature = "mutants")]
static ACTIVE: std::sync::atomic::AtomicU8 = std::sync::atomic::AtomicU8::new(0);

/// Switches this mistake on for the whole process, or all off.
#[cfg(feature = "mutants")]
pub fn switch(mutant: Option<Mutant>) {
    ACTIVE.store(mutant.map_or(0, |mutant| mutant as u8), std::sync::atomic::Ordering::SeqCst);
}

/// Whether this mistake is on.
#[cfg(feature = "mutants")]
pub fn is_on(mutant: Mutant) -> bool {
    ACTIVE.load(std::sync::atomic::Ordering::Relaxed) == mutant as u8
}

/// Whether this mistake is on.
#[cfg(not(feature = "mutants"))]
pub const fn is_on(_: Mutant) -> bool {
    false
}
