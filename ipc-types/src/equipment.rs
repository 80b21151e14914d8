//! What the cell's equipment reports: conveyor, dispenser, sensors, suction.

use crate::validate::{Check, Invalid, Validate, code};
use crate::wire::wire;

/// Sensors a cell can have.
pub const MAX_SENSORS: usize = 8;

/// A belt is not faster (m/s).
const MAX_BELT_SPEED: f64 = 10.0;

code! {
    /// Why suction attached nothing when it was switched on.
    pub enum SuctionRefusal {
        /// It did not refuse.
        None = 0,
        /// Nothing within the grip distance in front of the cup.
        NothingThere = 1,
        /// What is there cannot be held: it stands still.
        NotMovable = 2,
        /// The surface is too oblique for the cup.
        TooOblique = 3,
    }
}

code! {
    /// Which limit of a suction grip was exceeded.
    pub enum BreakLimit {
        /// It did not break.
        None = 0,
        /// Force.
        Force = 1,
        /// Torque.
        Torque = 2,
    }
}

code! {
    /// What exceeded it.
    pub enum BreakCause {
        /// It did not break.
        None = 0,
        /// The load was too heavy: it would have broken at rest.
        Weight = 1,
        /// A blow: parts that fell in, or a collision.
        Impulse = 2,
    }
}

code! {
    /// Why no bin came when one was asked for.
    pub enum SupplyRefusal {
        /// It came.
        None = 0,
        /// Every bin is in the cell.
        NoneLeft = 1,
        /// Enough of them wait on the belt.
        TooManyWaiting = 2,
        /// The last one came a moment ago.
        CoolDown = 3,
        /// Something stands where it would come.
        PlaceTaken = 4,
    }
}

wire! {
    /// Inputs from the cell's equipment, like those of a PLC.
    pub struct EquipmentState {
        /// Speed of the belt's surface, m/s.
        pub conveyor_speed: f64,
        /// Counts bins that came.
        pub bins_supplied: u32,
        /// Counts bins that were asked for and did not come.
        pub supply_refusals: u32,
        /// [`SupplyRefusal`] of the last of them.
        pub supply_refusal: u32,
        /// Counts parts that were dropped.
        pub parts_dropped: u32,
        /// Parts that were asked for and are still to fall.
        pub parts_waiting: u32,
        /// Counts objects that fell out of the cell and were put away.
        pub cleared: u32,
        /// By sensor of the cell file: index of the object that interrupts it
        /// plus 1; 0 for none.
        pub sensors: [u32; MAX_SENSORS],
    }
}

impl Validate for EquipmentState {
    fn validate(&self) -> Result<(), Invalid> {
        Check::within(
            "equipment.conveyor_speed",
            &[self.conveyor_speed],
            MAX_BELT_SPEED,
        )
    }
}
