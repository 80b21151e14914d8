//! The skills and conditions as node types, for trees in files and for the steps of machines
//! and matrices.

mod conditions;
mod guarded;
mod motions;
mod names;
mod poses;
mod way;
mod zones;

use std::sync::Arc;

use behavior::board::{Fault, In};
use behavior::tree::{Cx, Leaf, Library, NodeType};
use behavior::{Status, Str};
use robocell_task::PolicyTime;

use crate::condition::PLACE_TOLERANCE_M;
use crate::equipment::{AddBin, Conveyor, DropParts, Wait};
use crate::grip::{Close, Open};
use crate::motion::{FollowOperator, Home};
use crate::pick::Pick;
use crate::place::Place;
use crate::progress::Progress;
use crate::setup::Setup;
use crate::skill::{Skill, Station};
use names::{able_to_grip, is_given, object, place_named};

/// The resource that motions drive; a tree has one arm.
pub(crate) const ARM: &str = "arm";

/// The context of a call of a leaf.
pub type Context<'a, 'w> = Cx<'a, 'w, Station>;

/// Names that nodes use if no port gives another, see [`with_work`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkKeys {
    /// Key of the tree's own blackboard: name of the object on which it works, empty for none.
    pub object: &'static str,
    /// Key of the tree's own blackboard: position of that object when it was aimed at (m).
    pub reference: &'static str,
    /// Prefix of the shared keys with the owner of each object.
    pub owners: &'static str,
    /// The zone in which nodes work.
    pub zone: &'static str,
}

impl Default for WorkKeys {
    fn default() -> Self {
        Self {
            object: "current_object",
            reference: "pickup_reference",
            owners: "object_state",
            zone: "zone",
        }
    }
}

/// All node types for a cell. Names of objects, places and sensors in a file are checked when
/// it is loaded.
pub fn library(setup: &Arc<Setup>) -> Library<Station> {
    with_work(skills(setup), setup, WorkKeys::default())
}

/// Adds the node types for arms in a shared cell, and for trees with a recovery branch.
pub fn with_work(
    library: Library<Station>,
    setup: &Arc<Setup>,
    keys: WorkKeys,
) -> Library<Station> {
    zones::add(guarded::add(library, keys), setup, keys)
}

fn skills(setup: &Arc<Setup>) -> Library<Station> {
    let library = Library::default()
        .with(motions::move_to(setup))
        .with(motions::up())
        .with(
            plain(
                "Home",
                "Brings the joints to where they were at the start.",
                || Home,
            )
            .drives(ARM),
        )
        .with(plain(
            "Open",
            "Opens the gripper, or switches suction off.",
            || Open,
        ))
        .with(close(setup))
        .with(pick(setup))
        .with(place(setup))
        .with(
            plain(
                "FollowOperator",
                "Follows the operator's target and gripper requests; never ends.",
                || FollowOperator,
            )
            .drives(ARM),
        )
        .with(plain("AddBin", "Asks for the next bin.", || AddBin))
        .with(plain("DropParts", "Asks the dispenser for parts.", || {
            DropParts
        }))
        .with(conveyor())
        .with(stay())
        .with(fail());
    conditions::add(library, setup)
}

/// A leaf whose skill is created from its ports in every tick. `None`, for an object or a place
/// that does not exist, is a failure.
struct Made<F>(F);

impl<S, F> Leaf<Station> for Made<F>
where
    S: Skill,
    F: Fn(&Context<'_, '_>) -> Result<Option<S>, Fault> + Send + 'static,
{
    type State = Progress;

    fn start(&self, state: &mut Progress, _cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        state.reset();
        Ok(())
    }

    fn tick(&self, state: &mut Progress, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        // Ports are read in every tick, since keys of the blackboard may change; the progress
        // is kept.
        match (self.0)(cx)? {
            Some(skill) => Ok(skill.step(state, cx.world)),
            None => Ok(Status::Failure),
        }
    }
}

fn plain<S: Skill>(name: &'static str, doc: &'static str, make: fn() -> S) -> NodeType<Station> {
    NodeType::new(name, doc, move |_| {
        Ok(Made(move |_: &Context<'_, '_>| Ok(Some(make()))))
    })
}

fn seconds(time: f64) -> PolicyTime {
    PolicyTime::from_seconds(time)
}

/// `Close`.
fn close(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "Close",
        "Closes the gripper, or switches suction on. Fails when the object, or \
         without one anything, is not in the gripper then.",
        move |binder| {
            let wanted = if is_given(binder, "object") {
                Some(object(binder, &setup)?)
            } else {
                None
            };
            able_to_grip(binder, &setup, wanted.as_ref())?;
            Ok(Made(move |cx: &Context<'_, '_>| {
                Ok(match &wanted {
                    Some(name) => name.get(cx)?.map(|object| Close {
                        object: Some(object),
                    }),
                    None => Some(Close { object: None }),
                })
            }))
        },
    )
    .keywords(&["grasp", "grip", "suction", "attach"])
    .input_or(
        "object",
        Str::EMPTY,
        "object that has to be in the gripper then",
    )
}

/// `Pick`.
fn pick(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "Pick",
        "Picks an object up by the best grasp that nothing excludes: before it, to it, \
         close, lift. Succeeds at once with an object that is in the gripper. Starts \
         again when the object moves; after a failure it takes the next grasp. Fails \
         before the arm moves where there is none.",
        move |binder| {
            let object = object(binder, &setup)?;
            able_to_grip(binder, &setup, Some(&object))?;
            let clearance = binder.input::<f64>("clearance_m")?;
            let attempts = binder.input::<i64>("max_attempts")?;
            Ok(Made(move |cx: &Context<'_, '_>| {
                let Some(object) = object.get(cx)? else {
                    return Ok(None);
                };
                Ok(Some(Pick {
                    object,
                    clearance_m: cx.get(&clearance)?,
                    max_attempts: u32::try_from(cx.get(&attempts)?).unwrap_or(1),
                }))
            }))
        },
    )
    .keywords(&["grasp", "take", "lift"])
    .drives(ARM)
    .input::<Str>("object", "the object")
    .input_or(
        "clearance_m",
        0.1,
        "distance before the grasp, and height of the lift (m)",
    )
    .within(0.0, 1.0)
    .input_or("max_attempts", 5_i64, "failures in a row that fail the job")
    .within(1.0, 1000.0)
}

/// `Place`.
fn place(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "Place",
        "Brings the object in the gripper to the next free slot of a place: up, \
         across, down, open, up. Fails before the arm moves where it does not fit, and \
         when it is lost or does not stay there; after too many failures in a row the \
         job fails.",
        move |binder| {
            let object = object(binder, &setup)?;
            let place = place_named(binder, &setup)?;
            let clearance = binder.input::<f64>("clearance_m")?;
            let tolerance = binder.input::<f64>("tolerance_m")?;
            let attempts = binder.input::<i64>("max_attempts")?;
            Ok(Made(move |cx: &Context<'_, '_>| {
                let Some((object, place)) = object.get(cx)?.zip(place.get(cx)?) else {
                    return Ok(None);
                };
                Ok(Some(Place {
                    object,
                    place,
                    clearance_m: cx.get(&clearance)?,
                    tolerance_m: cx.get(&tolerance)?,
                    max_attempts: u32::try_from(cx.get(&attempts)?).unwrap_or(1),
                }))
            }))
        },
    )
    .keywords(&["put", "release", "stack"])
    .drives(ARM)
    .input::<Str>("object", "the object")
    .input::<Str>("place", "a place of [task]")
    .input_or("clearance_m", 0.1, "height at which the object travels (m)")
    .within(0.0, 1.0)
    .input_or(
        "tolerance_m",
        PLACE_TOLERANCE_M,
        "in its slot when nearer (m)",
    )
    .within(1.0e-4, 1.0)
    .input_or("max_attempts", 5_i64, "failures in a row that fail the job")
    .within(1.0, 1000.0)
}

fn conveyor() -> NodeType<Station> {
    NodeType::new("Conveyor", "Starts or stops the belt.", |binder| {
        let run = binder.input::<bool>("run")?;
        Ok(Made(move |cx: &Context<'_, '_>| {
            Ok(Some(Conveyor { run: cx.get(&run)? }))
        }))
    })
    .keywords(&["belt"])
    .input::<bool>("run", "whether it shall run")
}

fn stay() -> NodeType<Station> {
    NodeType::new("Stay", "The arm stays where it was sent.", |binder| {
        let time = binder.input::<f64>("for_s")?;
        Ok(Made(move |cx: &Context<'_, '_>| {
            Ok(Some(Wait {
                time: seconds(cx.get(&time)?),
            }))
        }))
    })
    .keywords(&["hold", "pause", "sleep"])
    .input::<f64>("for_s", "for how long (s)")
    .within(0.0, 3600.0)
}

/// Name of the node type that fails the job.
pub(crate) const FAIL_JOB: &str = "FailJob";

/// Fails the job.
struct FailJob {
    reason: In<Str>,
}

impl Leaf<Station> for FailJob {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let reason = cx.get(&self.reason)?;
        cx.world.fail(reason.as_str(), format_args!("{reason}"));
        Ok(Status::Failure)
    }
}

fn fail() -> NodeType<Station> {
    NodeType::new(
        FAIL_JOB,
        "Gives the job up: the arm holds, the run ends with this reason.",
        |binder| {
            Ok(FailJob {
                reason: binder.input("reason")?,
            })
        },
    )
    .keywords(&["abort", "give up", "error"])
    .input::<Str>("reason", "stable name of the reason, like_this")
}
