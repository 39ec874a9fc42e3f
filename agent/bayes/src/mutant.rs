//! Known mistakes, to prove that the tests detect them.
//!
//! Each mistake is a plausible wrong line in place of the right one. With the feature `mutants`,
//! which only `csat-tests` enables, one of them can be switched on for the whole process. Without the
//! feature `is_on` is `false` at compile time.

/// A known mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Mutant {
    /// A factor that arrives again is applied again.
    FactorAppliedTwice = 1,
    /// A new incarnation is taken for the one before: its factors count as known by their numbers.
    IncarnationIgnored,
    /// Frames without a detection are not applied.
    NoDetectionDropped,
    /// The factor of another aircraft is applied with the own pose.
    OwnPoseForOthers,
    /// A detection is never taken for a false alarm.
    FalseAlarmForgotten,
    /// Beliefs are fused by their product.
    SnapshotByProduct,
    /// Factors that others are missing are never sent again.
    NeverRepairs,
    /// The errors of reported attitudes are left out of the likelihood.
    AttitudeExact,
    /// Factors are applied in the order of their arrival.
    OrderOfArrival,
    /// Factors of earlier steps are not applied.
    LateLeftOut,
    /// Late factors of a target that moves are applied as if they were of now.
    LateAsNow,
    /// A target that moves is believed to stand.
    WalkForgotten,
    /// Frames with a detection do not count in P(D).
    DetectionsNotCounted,
    /// A restarted agent numbers its factors as its first life did.
    FirstLifeForEver,
    /// Messages of incarnations that are over are believed.
    OldLivesBelieved,
    /// An agent tells that it holds all factors up to the newest.
    GapsNotTold,
    /// Only own factors are sent again.
    RelaysNothing,
    /// Of two factors of one identity the newer one stays.
    NewerStays,
}

impl Mutant {
    /// All of them.
    pub const ALL: [Self; 18] = [
        Self::FactorAppliedTwice,
        Self::IncarnationIgnored,
        Self::NoDetectionDropped,
        Self::OwnPoseForOthers,
        Self::FalseAlarmForgotten,
        Self::SnapshotByProduct,
        Self::NeverRepairs,
        Self::AttitudeExact,
        Self::OrderOfArrival,
        Self::LateLeftOut,
        Self::LateAsNow,
        Self::WalkForgotten,
        Self::DetectionsNotCounted,
        Self::FirstLifeForEver,
        Self::OldLivesBelieved,
        Self::GapsNotTold,
        Self::RelaysNothing,
        Self::NewerStays,
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

/// Whether this mistake is on: never.
#[cfg(not(feature = "mutants"))]
#[inline(always)]
pub fn is_on(_: Mutant) -> bool {
    false
}
