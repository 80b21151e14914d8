//! The enabled obstacles in blocks of four, the layout that the kernel reads.

use crate::lanes::LANES;
use crate::shape::{Core, Obstacle};

/// Rows of a [`Block`]: centre, the three box axes in the base frame, half
/// extents, radius.
const ROWS: usize = 16;

/// Four obstacles, structure of arrays.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Block(pub(crate) [[f64; LANES]; ROWS]);

/// Centre coordinate of an unused lane, m: so far away that its weight is exactly zero.
const PARKED: f64 = 1e7;

const EMPTY_BLOCK: Block = {
    let mut rows = [[0.0; LANES]; ROWS];
    rows[0] = [PARKED; LANES];
    // Axes of the identity.
    rows[3] = [1.0; LANES];
    rows[7] = [1.0; LANES];
    rows[11] = [1.0; LANES];
    Block(rows)
};

/// The enabled parts, as the kernel reads them.
#[derive(Debug, Clone)]
pub(crate) struct Packed {
    /// Boxes around the parts, with unused lanes parked.
    blocks: Vec<Block>,
    /// Their shapes, by place.
    cores: Vec<Core>,
    /// Id of the obstacle of each, by place.
    owners: Vec<usize>,
}

impl Packed {
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self {
            blocks: Vec::with_capacity(capacity.div_ceil(LANES)),
            cores: Vec::with_capacity(capacity),
            owners: Vec::with_capacity(capacity),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.cores.is_empty()
    }

    pub(crate) fn len(&self) -> usize {
        self.cores.len()
    }

    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    pub(crate) fn core(&self, place: usize) -> &Core {
        &self.cores[place]
    }

    pub(crate) fn owner(&self, place: usize) -> usize {
        self.owners[place]
    }

    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.cores.clear();
        self.owners.clear();
    }

    /// Adds a part of the obstacle `owner`; returns its place.
    pub(super) fn push(&mut self, obstacle: &Obstacle, owner: usize) -> usize {
        let place = self.cores.len();
        // A new block has its lanes parked, so a partly filled one needs no count.
        if place.is_multiple_of(LANES) {
            self.blocks.push(EMPTY_BLOCK);
        }
        self.cores.push(obstacle.core.clone());
        self.owners.push(owner);
        self.move_to(place, obstacle);
        place
    }

    /// Updates the box around the part at `place`.
    pub(super) fn move_to(&mut self, place: usize, obstacle: &Obstacle) {
        let axes = obstacle.pose.rotation.to_rotation_matrix().into_inner();
        let center = obstacle.pose.translation.vector + axes * obstacle.core.middle();
        let half = obstacle.half_extents();
        let rows = &mut self.blocks[place / LANES].0;
        let values = center.iter().chain(axes.iter()).chain(half.iter());
        let values = values.chain(std::iter::once(&obstacle.radius));
        for (row, value) in rows.iter_mut().zip(values) {
            row[place % LANES] = *value;
        }
    }
}
