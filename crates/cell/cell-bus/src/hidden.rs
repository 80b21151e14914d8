//! Ports behind trait objects.

use core::fmt::Debug;
use core::ops::Deref;

/// A value of the transport that other crates own without compiling it again.
///
/// A crate that drops a value compiles how it is dropped, and with a port of
/// iceoryx2 that is most of iceoryx2: about 300,000 lines of LLVM code in each of
/// six crates. Behind a trait object it is compiled where the object is made,
/// which is in this crate.
#[derive(Debug)]
pub(crate) struct Hidden<P>(Box<dyn Held<P>>);

impl<P: Debug + 'static> Hidden<P> {
    pub(crate) fn new(port: P) -> Self {
        Self(Box::new(port))
    }
}

impl<P> Deref for Hidden<P> {
    type Target = P;

    fn deref(&self) -> &P {
        (*self.0).held()
    }
}

trait Held<P>: Debug {
    fn held(&self) -> &P;
}

impl<P: Debug> Held<P> for P {
    fn held(&self) -> &P {
        self
    }
}
