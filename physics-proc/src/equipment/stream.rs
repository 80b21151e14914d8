//! Random numbers of the equipment.

use cell_model::random::Random;

/// Random numbers of the equipment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stream {
    /// Seed of the run.
    pub(super) seed: u64,
}

impl Stream {
    /// A generator for item `index` of a device. The result depends only on the seed, the
    /// device and that number.
    pub(super) fn random(self, device: u64, index: u64) -> Random {
        let mut devices = Random::new(self.seed.wrapping_add(device << 32));
        Random::new(devices.bits().wrapping_add(index))
    }
}
