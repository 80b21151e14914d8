//! The checkpoint of a cycle: its whole state, as plain little-endian bytes.
//!
//! One function per type lists its fields, for writing and for reading, so the two can never
//! disagree. The rules for a change:
//!
//! - A field that is added, removed or moved needs a new [`VERSION`]: the bytes have no names,
//!   and an old checkpoint would be read as other fields.
//! - Numbers are kept to the bit. A value that is rounded makes a replay differ within a
//!   cycle.
//! - Each value that is used as an index or a code is checked here: the bytes come from a file
//!   that may be damaged, and a wrong index would end the process.
//! - Nothing allocates while writing: a checkpoint is written within a cycle.

use nalgebra::{Isometry3, UnitQuaternion};

/// Version of the layout; another one is refused.
pub const VERSION: u32 = 8;

/// Reason why a checkpoint was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointError {
    /// Written by another version.
    #[error(
        "the controller's checkpoint has layout version {found}, this build reads {VERSION}; use the build that wrote it"
    )]
    Version {
        /// Version in the checkpoint.
        found: u32,
    },
    /// Written for another arm or another robot.
    #[error(
        "the controller's checkpoint has {what} {found}, this arm has {expected}; it is of another cell"
    )]
    OtherArm {
        /// The property that differs.
        what: &'static str,
        /// In the checkpoint.
        found: u64,
        /// The value of this arm.
        expected: u64,
    },
    /// A value outside of its range.
    #[error("the controller's checkpoint is damaged: {what} is {found}")]
    Damaged {
        /// The field.
        what: &'static str,
        /// Its value.
        found: u64,
    },
    /// Too few bytes, or too many; or no room to write.
    #[error("the controller's checkpoint has {bytes} bytes, it needs {needed}")]
    Length {
        /// Bytes present.
        bytes: usize,
        /// Bytes needed, as far as it was read.
        needed: usize,
    },
}

/// A place in a checkpoint that is written or read.
pub(crate) struct Codec<'a> {
    direction: Direction<'a>,
    at: usize,
}

enum Direction<'a> {
    Write(&'a mut [u8]),
    Read(&'a [u8]),
}

impl<'a> Codec<'a> {
    /// A checkpoint to write into `bytes`.
    pub(crate) fn write(bytes: &'a mut [u8]) -> Self {
        Self {
            direction: Direction::Write(bytes),
            at: 0,
        }
    }

    /// A checkpoint to read from `bytes`.
    pub(crate) fn read(bytes: &'a [u8]) -> Self {
        Self {
            direction: Direction::Read(bytes),
            at: 0,
        }
    }

    /// Bytes written or read so far.
    pub(crate) fn len(&self) -> usize {
        self.at
    }

    /// Whether values are read, and not written.
    pub(crate) fn reads(&self) -> bool {
        matches!(self.direction, Direction::Read(_))
    }

    /// Checks that everything was read.
    pub(crate) fn end(&self) -> Result<(), CheckpointError> {
        // More bytes than fields is another layout, even if each field was plausible.
        match &self.direction {
            Direction::Read(bytes) if bytes.len() != self.at => Err(CheckpointError::Length {
                bytes: bytes.len(),
                needed: self.at,
            }),
            _ => Ok(()),
        }
    }

    pub(crate) fn bytes(&mut self, value: &mut [u8]) -> Result<(), CheckpointError> {
        let (from, to) = (self.at, self.at + value.len());
        let short = |bytes: usize| CheckpointError::Length { bytes, needed: to };
        match &mut self.direction {
            Direction::Write(bytes) => {
                let length = bytes.len();
                let place = bytes.get_mut(from..to).ok_or(short(length))?;
                place.copy_from_slice(value);
            }
            Direction::Read(bytes) => {
                let place = bytes.get(from..to).ok_or(short(bytes.len()))?;
                value.copy_from_slice(place);
            }
        }
        self.at = to;
        Ok(())
    }

    pub(crate) fn u64(&mut self, value: &mut u64) -> Result<(), CheckpointError> {
        let mut bytes = value.to_le_bytes();
        self.bytes(&mut bytes)?;
        *value = u64::from_le_bytes(bytes);
        Ok(())
    }

    pub(crate) fn u32(&mut self, value: &mut u32) -> Result<(), CheckpointError> {
        let mut bytes = value.to_le_bytes();
        self.bytes(&mut bytes)?;
        *value = u32::from_le_bytes(bytes);
        Ok(())
    }

    /// Bit by bit.
    pub(crate) fn f64(&mut self, value: &mut f64) -> Result<(), CheckpointError> {
        let mut bits = value.to_bits();
        self.u64(&mut bits)?;
        *value = f64::from_bits(bits);
        Ok(())
    }

    /// The values of a list whose length is fixed.
    pub(crate) fn f64s<'v>(
        &mut self,
        values: impl IntoIterator<Item = &'v mut f64>,
    ) -> Result<(), CheckpointError> {
        values.into_iter().try_for_each(|value| self.f64(value))
    }

    /// Bit by bit: normalising again would change the last bits.
    pub(crate) fn rotation(
        &mut self,
        rotation: &mut UnitQuaternion<f64>,
    ) -> Result<(), CheckpointError> {
        let mut coordinates = rotation.coords;
        self.f64s(coordinates.iter_mut())?;
        *rotation = UnitQuaternion::new_unchecked(coordinates.into());
        Ok(())
    }

    /// Translation, then rotation.
    pub(crate) fn pose(&mut self, pose: &mut Isometry3<f64>) -> Result<(), CheckpointError> {
        self.f64s(pose.translation.vector.iter_mut())?;
        self.rotation(&mut pose.rotation)
    }

    pub(crate) fn bool(
        &mut self,
        what: &'static str,
        value: &mut bool,
    ) -> Result<(), CheckpointError> {
        let mut code = u32::from(*value);
        self.u32(&mut code)?;
        *value = match code {
            0 => false,
            1 => true,
            found => return Err(damaged(what, u64::from(found))),
        };
        Ok(())
    }

    /// An index below `count`.
    pub(crate) fn index(
        &mut self,
        what: &'static str,
        value: &mut usize,
        count: usize,
    ) -> Result<(), CheckpointError> {
        let mut wide = *value as u64;
        self.u64(&mut wide)?;
        *value = usize::try_from(wide)
            .ok()
            .filter(|index| *index < count)
            .ok_or(damaged(what, wide))?;
        Ok(())
    }

    /// A list of at most `most` values.
    pub(crate) fn list<T: Default + Clone>(
        &mut self,
        what: &'static str,
        list: &mut Vec<T>,
        most: usize,
        mut inner: impl FnMut(&mut Self, &mut T) -> Result<(), CheckpointError>,
    ) -> Result<(), CheckpointError> {
        let mut count = list.len();
        // The count is checked before the list grows: a damaged one must not allocate.
        self.index(what, &mut count, most + 1)?;
        list.resize(count, T::default());
        list.iter_mut().try_for_each(|value| inner(self, value))
    }

    /// A value that may be missing.
    pub(crate) fn option<T: Default>(
        &mut self,
        what: &'static str,
        value: &mut Option<T>,
        mut inner: impl FnMut(&mut Self, &mut T) -> Result<(), CheckpointError>,
    ) -> Result<(), CheckpointError> {
        let mut present = value.is_some();
        self.bool(what, &mut present)?;
        if !present {
            *value = None;
            return Ok(());
        }
        inner(self, value.get_or_insert_default())
    }

    /// A value that has to be equal where the checkpoint is read.
    pub(crate) fn same(
        &mut self,
        what: &'static str,
        expected: u64,
    ) -> Result<(), CheckpointError> {
        let mut found = expected;
        self.u64(&mut found)?;
        if found == expected {
            return Ok(());
        }
        Err(CheckpointError::OtherArm {
            what,
            found,
            expected,
        })
    }
}

pub(crate) fn damaged(what: &'static str, found: u64) -> CheckpointError {
    CheckpointError::Damaged { what, found }
}
