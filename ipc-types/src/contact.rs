//! Pairs of bodies in contact and their forces: for people, not for control.

use crate::header::Header;
use crate::validate::{Check, Invalid, MAX_EFFORT, Validate, code};
use crate::wire::wire;

/// Contacts of one message: those with the largest forces.
// Only people look at them, and the page draws the largest.
pub const MAX_CONTACTS: usize = 96;

/// Largest plausible coordinate of a contact (m).
const MAX_PLACE_M: f64 = 100.0;

code! {
    /// What kind of body takes part in a contact.
    pub enum BodyKind {
        /// An object, by its place in the cell file.
        Object = 0,
        /// A solid fixture, by its place in the cell file.
        Fixture = 1,
        /// A link of an arm, by the place of the arm in the cell file.
        Arm = 2,
    }
}

wire! {
    /// Two bodies that touch.
    pub struct Contact {
        /// [`BodyKind`] of the first body in the high half, its index in the low one.
        pub a: u32,
        /// The second body, likewise.
        pub b: u32,
        /// Mean of the contact points, weighted by their forces (m, world frame).
        pub position: [f64; 3],
        /// Force on the first body (N, world frame); the second one feels its opposite.
        pub force: [f64; 3],
    }
}

wire! {
    /// Physics to monitor, every [`CONTACT_TICKS`] ticks.
    pub struct Contacts {
        /// Header; `tick` is the tick of the state these are of.
        pub header: Header,
        /// Valid entries of `contacts`.
        pub count: u32,
        /// Number of all contacts, including those beyond the capacity.
        pub total: u32,
        /// Largest force first.
        pub contacts: [Contact; MAX_CONTACTS],
    }
}

/// Interval at which contacts are published (ticks).
// 50 Hz: as fast as a page draws.
pub const CONTACT_TICKS: u64 = 20;

impl Contact {
    /// `kind` and `index` as one number.
    pub fn body(kind: BodyKind, index: usize) -> u32 {
        // Two halves of one number, so that a contact needs no more than its 56 bytes.
        (kind.code() << 16) | u32::try_from(index).unwrap_or(0xffff).min(0xffff)
    }
}

impl Contacts {
    /// The contacts.
    pub fn list(&self) -> &[Contact] {
        &self.contacts[..(self.count as usize).min(MAX_CONTACTS)]
    }
}

impl Validate for Contacts {
    fn validate(&self) -> Result<(), Invalid> {
        Check::count("count", self.count, MAX_CONTACTS)?;
        for contact in self.list() {
            for body in [contact.a, contact.b] {
                let kind = BodyKind::from_code(body >> 16);
                // Unknown kinds are refused, as a reader chooses a list of bodies by them.
                Check::code("contact.body", body >> 16, kind.is_some())?;
            }
            Check::within("contact.position", &contact.position, MAX_PLACE_M)?;
            Check::within("contact.force", &contact.force, MAX_EFFORT)?;
        }
        Ok(())
    }
}
