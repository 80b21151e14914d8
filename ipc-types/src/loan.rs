//! A message written where its readers will find it.

use iceoryx2::port::LoanError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{ZeroCopySend, ipc};
use iceoryx2::sample_mut::SampleMut;

use crate::Wire;

/// Memory of the publisher's data segment to write one message into.
///
/// It holds what some earlier message left there, or zeros: the writer sets
/// every field a reader may look at. Errors: all loans are out, or the segment
/// is corrupted.
pub fn loan<T: Wire + ZeroCopySend + core::fmt::Debug>(
    publisher: &Publisher<ipc::Service, T, ()>,
) -> Result<SampleMut<ipc::Service, T, ()>, LoanError> {
    let sample = publisher.loan_uninit()?;
    // SAFETY: the memory is a mapping the kernel initialised, aligned for `T`
    // by the port, and every bit pattern is a value of a `Wire` type.
    Ok(unsafe { sample.assume_init() })
}
