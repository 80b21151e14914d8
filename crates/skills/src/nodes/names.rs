//! Names of objects, places and sensors in ports.

use behavior::Str;
use behavior::board::{Fault, In};
use behavior::suggest;
use behavior::tree::{BindError, Binder, Binding};

use super::Context;
use crate::setup::Setup;

/// A name that a port is bound to: resolved when the file is loaded, or looked
/// up at every tick where it is in a key.
#[derive(Clone, Copy)]
pub(super) enum Named {
    Index(usize),
    Key(In<Str>, fn(&Setup, &str) -> Option<usize>),
}

impl Named {
    pub(super) fn get(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        match self {
            Self::Index(index) => Ok(Some(*index)),
            Self::Key(key, find) => Ok(find(cx.world.setup, cx.get(key)?.as_str())),
        }
    }
}

#[allow(clippy::result_large_err, reason = "happens at load, once")]
pub(super) fn named(
    binder: &mut Binder<'_>,
    port: &str,
    setup: &Setup,
    find: fn(&Setup, &str) -> Option<usize>,
    known: impl Fn(&Setup) -> Vec<&str>,
) -> Result<Named, BindError> {
    let bound = binder.input::<Str>(port)?;
    let In::Literal(name) = bound else {
        return Ok(Named::Key(bound, find));
    };
    let known = known(setup);
    if known.is_empty() && setup.arms.is_empty() {
        // A file that is looked at without its cell.
        return Ok(Named::Index(usize::MAX));
    }
    find(setup, name.as_str()).map(Named::Index).ok_or_else(|| {
        let advice = suggest::advice(name.as_str(), &known);
        BindError::Host(format!("there is no {port} '{name}'; {advice}"))
    })
}

#[allow(clippy::result_large_err, reason = "happens at load, once")]
pub(super) fn object(binder: &mut Binder<'_>, setup: &Setup) -> Result<Named, BindError> {
    named(binder, "object", setup, Setup::object, |setup| {
        setup.objects.iter().map(|o| o.name.as_str()).collect()
    })
}

#[allow(clippy::result_large_err, reason = "happens at load, once")]
pub(super) fn place_named(binder: &mut Binder<'_>, setup: &Setup) -> Result<Named, BindError> {
    named(binder, "place", setup, Setup::place, |setup| {
        setup.places.iter().map(|p| p.name.as_str()).collect()
    })
}

#[allow(clippy::result_large_err, reason = "happens at load, once")]
pub(super) fn sensor(binder: &mut Binder<'_>, setup: &Setup) -> Result<Named, BindError> {
    named(binder, "sensor", setup, Setup::sensor, |setup| {
        setup.sensors.iter().map(String::as_str).collect()
    })
}

/// Whether a port was given, whose default is an empty text or no numbers.
pub(super) fn is_given(binder: &Binder<'_>, port: &str) -> bool {
    match binder.bindings.get(port) {
        Some(Binding::Literal(behavior::Value::Text(text))) => !text.is_empty(),
        Some(Binding::Literal(behavior::Value::Numbers(list))) => !list.as_slice().is_empty(),
        Some(Binding::Key(..)) => true,
        _ => false,
    }
}
