//! The cell's equipment: conveyor, supply of bins, dispenser, light barriers.

pub(crate) mod conveyor;
pub(crate) mod devices;
pub(crate) mod dispenser;
pub(crate) mod parking;
pub(crate) mod sensors;
pub(crate) mod stream;
pub(crate) mod supply;
