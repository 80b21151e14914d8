//! Messages of the transport's bench: a header and numbers, in four sizes.

use crate::header::{Header, Message};
use crate::validate::{Invalid, MAX_EFFORT, Validate};
use crate::wire::wire;

/// A message whose payload is numbers, as those of the cell are.
pub trait Probe: Message {
    /// Payload in bytes.
    const PAYLOAD: usize;
    /// The numbers.
    fn values(&self) -> &[f64];
    /// The numbers, for the writer.
    fn values_mut(&mut self) -> &mut [f64];
    /// Sets the number of valid entries, as the counts of the cell's messages.
    fn set_used(&mut self, used: usize);
}

macro_rules! probe {
    ($(#[$meta:meta])* $name:ident, $values:literal) => {
        wire! {
            $(#[$meta])*
            pub struct $name {
                /// Header.
                pub header: Header,
                /// Valid entries of `values`.
                pub used: u64,
                /// Payload.
                pub values: [f64; $values],
            }
        }

        impl Validate for $name {
            fn validate(&self) -> Result<(), Invalid> {
                // The same work as for a message of the cell, or the
                // bench would measure less than it claims.
                let used = usize::try_from(self.used).unwrap_or(usize::MAX);
                let Some(values) = self.values.get(..used) else {
                    let allowed = "a count within capacity";
                    return Err(Invalid { field: "used", index: 0, value: self.used as f64, allowed });
                };
                plausible(values)
            }
        }

        impl Message for $name {
            fn header(&self) -> &Header {
                &self.header
            }
            fn header_mut(&mut self) -> &mut Header {
                &mut self.header
            }
        }

        impl Probe for $name {
            const PAYLOAD: usize = 8 * $values;
            fn values(&self) -> &[f64] {
                &self.values
            }
            fn values_mut(&mut self) -> &mut [f64] {
                &mut self.values
            }
            fn set_used(&mut self, used: usize) {
                self.used = used as u64;
            }
        }
    };
}

probe!(
    /// 64 bytes of payload.
    Probe64, 8
);
probe!(
    /// 1 KiB of payload.
    Probe1K, 128
);
probe!(
    /// 4 KiB of payload.
    Probe4K, 512
);
probe!(
    /// 16 KiB of payload.
    Probe16K, 2048
);

/// Every value finite and plausible, as for the efforts of a command.
fn plausible(values: &[f64]) -> Result<(), Invalid> {
    // Without an early exit the valid case compares several values at a time.
    let mut bad = 0;
    for value in values {
        bad |= u64::from(!(value.abs() <= MAX_EFFORT));
    }
    if bad == 0 {
        // Only now the index, as a bad value is rare.
        return Ok(());
    }
    let index = values
        .iter()
        .position(|v| !(v.abs() <= MAX_EFFORT))
        .unwrap_or(0);
    let value = values.get(index).copied().unwrap_or(f64::NAN);
    Err(Invalid {
        field: "values",
        index,
        value,
        allowed: "a finite, plausible value",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Wire;

    #[test]
    fn what_counts_is_checked_and_the_rest_is_not_looked_at() {
        let mut probe = Probe64::zeroed();
        probe.values[7] = f64::NAN;
        assert!(probe.validate().is_ok());
        probe.used = 8;
        assert_eq!(probe.validate().unwrap_err().index, 7);
        probe.used = 9;
        assert_eq!(probe.validate().unwrap_err().field, "used");
    }
}
