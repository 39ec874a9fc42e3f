//! Known mistakes, to prove that the tests detect them.
//!
//! Each mistake is a plausible wrong line in place of the right one. With the feature `mutants`,
//! which only tests enable, one of them can be switched on for the whole process. Without the
//! feature `is_on` is `false` at compile time.

/// A known mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Mutant {
    /// A frontier is deleted where it lies in the image of another cleaner, cleared or not.
    DeletedUnseen = 1,
    /// A frontier is given away as soon as another agent is asked.
    GivenAtOnce,
    /// Cleared ground grows up to the edge of what is known, and the frontier needs no distance from it.
    NoMargin,
    /// Roads connect along sides only.
    FourNeighbours,
    /// Safe masks are placed by the first offset of their sender.
    StaleOffset,
    /// Safe masks reach up to unknown road.
    NoRho,
    /// What enters the image beside cleared road is taken for cleared.
    EnteringCleared,
    /// The segmentation is taken for the road area.
    NoGaps,
}

impl Mutant {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::DeletedUnseen,
        Self::GivenAtOnce,
        Self::NoMargin,
        Self::FourNeighbours,
        Self::StaleOffset,
        Self::NoRho,
        Self::EnteringCleared,
        Self::NoGaps,
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
