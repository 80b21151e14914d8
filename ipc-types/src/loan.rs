//! A message written directly into the memory that its readers map.

use iceoryx2::port::LoanError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{ZeroCopySend, ipc};
use iceoryx2::sample_mut::SampleMut;

use crate::Wire;

/// Memory of the publisher's data segment for one message.
///
/// It holds the content of an earlier message, or zeros: the writer sets every field that a
/// reader may use. Errors: all loans are in use, or the segment is damaged.
pub fn loan<T: Wire + ZeroCopySend + core::fmt::Debug>(
    publisher: &Publisher<ipc::Service, T, ()>,
) -> Result<SampleMut<ipc::Service, T, ()>, LoanError> {
    // Zeroing 20 kB in every cycle would cost as much as writing a state.
    let sample = publisher.loan_uninit()?;
    // SAFETY: the memory is a mapping the kernel initialised, aligned for `T`
    // by the port, and every bit pattern is a value of a `Wire` type.
    Ok(unsafe { sample.assume_init() })
}
