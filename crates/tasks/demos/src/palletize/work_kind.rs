//! The kinds of work on a bin.

use serde::{Deserialize, Serialize};

/// A sequence of steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum WorkKind {
    /// Pick a bin that opens upwards.
    Pick,
    /// Pick a bin that is upside down.
    PickFlipped,
    /// Bring a bin to the jig.
    Flip,
    /// Set a bin down.
    Place,
    /// Set a bin down that was picked from the belt.
    PlaceFromBelt,
    /// Set a bin down over the rest pose, after an attempt that failed.
    PlaceFromHome,
}

impl WorkKind {
    /// All kinds; the index is that of their sequence.
    pub(super) const ALL: [Self; 6] = [
        Self::Pick,
        Self::PickFlipped,
        Self::Flip,
        Self::Place,
        Self::PlaceFromBelt,
        Self::PlaceFromHome,
    ];

    /// Whether it picks a bin, and does not start with one on the cup.
    pub(super) fn picks(self) -> bool {
        matches!(self, Self::Pick | Self::PickFlipped)
    }

    /// Whether it sets the bin down on the pallet.
    pub(super) fn places(self) -> bool {
        !self.picks() && self != Self::Flip
    }
}
