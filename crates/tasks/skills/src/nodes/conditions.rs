//! The conditions as node types.

use std::sync::Arc;

use behavior::board::Fault;
use behavior::tree::check::CONDITION;
use behavior::tree::{Leaf, Library, NodeType};
use behavior::{Status, Str};

use super::Context;
use super::names::{is_given, object, place_named, sensor};
use crate::condition::{Condition, PLACE_TOLERANCE_M};
use crate::setup::Setup;
use crate::skill::Station;

/// A condition that is created from its ports in every tick.
struct Asked<F>(F);

impl<F> Leaf<Station> for Asked<F>
where
    F: Fn(&Context<'_, '_>) -> Result<Option<Condition>, Fault> + Send + 'static,
{
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        // An unknown name makes a condition false, not a fault: its key may be written later.
        let holds = (self.0)(cx)?.is_some_and(|condition| condition.holds(cx.world));
        Ok(if holds {
            Status::Success
        } else {
            Status::Failure
        })
    }
}

/// Adds the conditions.
pub(super) fn add(library: Library<Station>, setup: &Arc<Setup>) -> Library<Station> {
    library
        .with(holding(setup))
        .with(is_at(setup))
        .with(is_full(setup))
        .with(fallen(setup))
        .with(about(
            setup,
            "Reachable",
            "The arm reaches the object.",
            Condition::Reachable,
        ))
        .with(about(
            setup,
            "AtRest",
            "The object does not move.",
            Condition::AtRest,
        ))
        .with(about(
            setup,
            "Uncovered",
            "No other object is on it.",
            Condition::Uncovered,
        ))
        .with(about(
            setup,
            "Upright",
            "The object's z axis points up.",
            Condition::Upright,
        ))
        .with(sensed(setup))
        .with(asked(
            "GripperOpen",
            "The gripper is open.",
            Condition::GripperOpen,
        ))
        .with(asked(
            "Started",
            "The operator has started the task.",
            Condition::Started,
        ))
}

fn asked(name: &'static str, doc: &'static str, condition: Condition) -> NodeType<Station> {
    NodeType::new(name, doc, move |_| {
        Ok(Asked(move |_: &Context<'_, '_>| Ok(Some(condition))))
    })
    .keywords(&[CONDITION])
}

fn about(
    setup: &Arc<Setup>,
    name: &'static str,
    doc: &'static str,
    make: fn(usize) -> Condition,
) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(name, doc, move |binder| {
        let object = object(binder, &setup)?;
        Ok(Asked(move |cx: &Context<'_, '_>| {
            Ok(object.get(cx)?.map(make))
        }))
    })
    .keywords(&[CONDITION])
    .input::<Str>("object", "the object")
}

fn holding(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "Holding",
        "The gripper holds the object, or without one anything.",
        move |binder| {
            let wanted = if is_given(binder, "object") {
                Some(object(binder, &setup)?)
            } else {
                None
            };
            Ok(Asked(move |cx: &Context<'_, '_>| {
                Ok(match &wanted {
                    Some(name) => name.get(cx)?.map(|object| Condition::Holding(Some(object))),
                    None => Some(Condition::Holding(None)),
                })
            }))
        },
    )
    .keywords(&[CONDITION, "gripped", "attached", "held"])
    .input_or("object", Str::EMPTY, "the object")
}

/// Adds the ports of a condition about the slots of a place.
fn slots(node_type: NodeType<Station>) -> NodeType<Station> {
    node_type
        .input::<Str>("place", "a place of [task]")
        .input_or(
            "tolerance_m",
            PLACE_TOLERANCE_M,
            "in its slot when nearer (m)",
        )
        .within(1.0e-4, 1.0)
}

fn is_at(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    slots(
        NodeType::new(
            "At",
            "The object is in a slot of the place, and in no gripper.",
            move |binder| {
                let object = object(binder, &setup)?;
                let place = place_named(binder, &setup)?;
                let tolerance = binder.input::<f64>("tolerance_m")?;
                Ok(Asked(move |cx: &Context<'_, '_>| {
                    let both = object.get(cx)?.zip(place.get(cx)?);
                    let tolerance_m = cx.get(&tolerance)?;
                    Ok(both.map(|(object, place)| Condition::At {
                        object,
                        place,
                        tolerance_m,
                    }))
                }))
            },
        )
        .keywords(&[CONDITION, "placed", "in place"])
        .input::<Str>("object", "the object"),
    )
}

fn is_full(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    slots(
        NodeType::new("Full", "No slot of the place is free.", move |binder| {
            let place = place_named(binder, &setup)?;
            let tolerance = binder.input::<f64>("tolerance_m")?;
            Ok(Asked(move |cx: &Context<'_, '_>| {
                let tolerance_m = cx.get(&tolerance)?;
                let place = place.get(cx)?;
                Ok(place.map(|place| Condition::Full { place, tolerance_m }))
            }))
        })
        .keywords(&[CONDITION, "complete"]),
    )
}

fn fallen(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "Fallen",
        "The object's centre is below a height: it fell off the table.",
        move |binder| {
            let object = object(binder, &setup)?;
            let below = binder.input::<f64>("below_m")?;
            Ok(Asked(move |cx: &Context<'_, '_>| {
                let below_m = cx.get(&below)?;
                Ok(object
                    .get(cx)?
                    .map(|object| Condition::Fallen { object, below_m }))
            }))
        },
    )
    .keywords(&[CONDITION, "lost", "floor"])
    .input::<Str>("object", "the object")
    .input_or("below_m", 0.0, "the height, world frame (m)")
    .within(-20.0, 20.0)
}

fn sensed(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "Sensor",
        "The light barrier is interrupted.",
        move |binder| {
            let sensor = sensor(binder, &setup)?;
            Ok(Asked(move |cx: &Context<'_, '_>| {
                Ok(sensor.get(cx)?.map(Condition::Sensor))
            }))
        },
    )
    .keywords(&[CONDITION, "light barrier"])
    .input::<Str>("sensor", "the sensor")
}
