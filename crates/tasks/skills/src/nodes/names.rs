//! Names of objects, places and sensors in ports.

use behavior::board::{Fault, In};
use behavior::suggest;
use behavior::tree::{BindError, Binder, Binding};
use behavior::{Str, Value};

use super::Context;
use crate::ability::{self, Need};
use crate::setup::{ARM, Setup};
use crate::shared::ROBOT;

/// A name of a port: resolved when the file is loaded, or looked up in every tick if it is in a
/// key.
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
    let known = known(setup);
    let In::Literal(name) = bound else {
        unknown_default(binder, port, setup, &known);
        return Ok(Named::Key(bound, find));
    };
    if known.is_empty() && setup.arms.is_empty() {
        // A file that is checked without its cell.
        return Ok(Named::Index(usize::MAX));
    }
    find(setup, name.as_str()).map(Named::Index).ok_or_else(|| {
        let advice = suggest::advice(name.as_str(), &known);
        BindError::Host(format!("unknown {port} '{name}'; {advice}"))
    })
}

/// Warns about a key whose default is not a name of the cell. Another name may be written
/// before it is read.
fn unknown_default(binder: &mut Binder<'_>, port: &str, setup: &Setup, known: &[&str]) {
    let Some(Value::Text(name)) = binder.initial(port) else {
        return;
    };
    if setup.arms.is_empty() || name.is_empty() || known.contains(&name.as_str()) {
        return;
    }
    let advice = suggest::advice(name.as_str(), known);
    let message = format!("the key of '{port}' starts with '{name}': unknown {port}; {advice}");
    binder.warn("unknown_default", message);
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

/// Refuses a node that picks up `object` (`None` if it is known later) if the arm of its tree
/// cannot (ADR 0026).
#[allow(clippy::result_large_err, reason = "happens at load, once")]
pub(super) fn able_to_grip(
    binder: &Binder<'_>,
    setup: &Setup,
    object: Option<&Named>,
) -> Result<(), BindError> {
    let named = binder.text_constant(ROBOT).ok();
    let arm = named.and_then(|name| setup.arm(name)).unwrap_or(ARM);
    // A file that is checked without its cell has no arms.
    let Some(spec) = setup.arms.get(arm) else {
        return Ok(());
    };
    let index = object.and_then(|object| match object {
        Named::Index(index) => Some(*index),
        Named::Key(..) => None,
    });
    let object = index.and_then(|index| setup.objects.get(index));
    if let Some(lack) = ability::lacks(spec, Need::Grip(object)) {
        let object = object.map(|object| object.name.as_str());
        return Err(BindError::Host(ability::refusal(&spec.name, object, lack)));
    }
    // Collected for warnings: whether the arm reaches the object is known with the cell only.
    if let Some(index) = index {
        setup.picks.note(arm, index);
    }
    Ok(())
}

/// Whether a port is given; its default is an empty text or an empty list.
pub(super) fn is_given(binder: &Binder<'_>, port: &str) -> bool {
    match binder.bindings.get(port) {
        Some(Binding::Literal(behavior::Value::Text(text))) => !text.is_empty(),
        Some(Binding::Literal(behavior::Value::Numbers(list))) => !list.as_slice().is_empty(),
        Some(Binding::Key(..)) => true,
        _ => false,
    }
}
