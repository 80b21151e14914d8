//! State of the cell's equipment: conveyor, dispenser, sensors, suction.

use crate::validate::{Check, Invalid, Validate, code};
use crate::wire::wire;

/// Sensors a cell can have.
pub const MAX_SENSORS: usize = 8;

/// Largest plausible speed of a belt (m/s).
const MAX_BELT_SPEED: f64 = 10.0;

code! {
    /// Reason why suction attached nothing when it was switched on.
    pub enum SuctionRefusal {
        /// It did not refuse.
        None = 0,
        /// No object within the grip distance in front of the cup.
        NothingThere = 1,
        /// The object cannot be held: it is a fixture.
        NotMovable = 2,
        /// The surface is too oblique for the cup.
        TooOblique = 3,
    }
}

code! {
    /// Limit of a suction grip that was exceeded.
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
    /// Cause of a broken grip.
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
    /// Reason why a requested bin was not supplied.
    pub enum SupplyRefusal {
        /// It was supplied.
        None = 0,
        /// Every bin is in the cell.
        NoneLeft = 1,
        /// Enough of them wait on the belt.
        TooManyWaiting = 2,
        /// The last one was supplied a moment ago.
        CoolDown = 3,
        /// The place of the supply is occupied.
        PlaceTaken = 4,
    }
}

wire! {
    /// Inputs from the cell's equipment, like those of a PLC.
    pub struct EquipmentState {
        /// Speed of the belt's surface, m/s.
        pub conveyor_speed: f64,
        /// Counts bins that were supplied.
        pub bins_supplied: u32,
        /// Counts requested bins that were not supplied.
        pub supply_refusals: u32,
        /// [`SupplyRefusal`] of the last of them.
        pub supply_refusal: u32,
        /// Counts parts that were dropped.
        pub parts_dropped: u32,
        /// Requested parts that have not fallen yet.
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
        // Counters need no check: their readers use differences.
        Check::within(
            "equipment.conveyor_speed",
            &[self.conveyor_speed],
            MAX_BELT_SPEED,
        )
    }
}
