//! The skills and conditions as node types, for trees in files and for the steps
//! of machines and matrices.

mod conditions;
mod guarded;
mod way;
mod zones;

use std::sync::Arc;

use behavior::board::{Fault, In};
use behavior::suggest;
use behavior::tree::{BindError, Binder, Binding, Cx, Leaf, Library, NodeType};
use behavior::value::Numbers;
use behavior::{Status, Str};
use ipc_types::Pose;
use robocell_task::PolicyTime;

use crate::condition::PLACE_TOLERANCE_M;
use crate::equipment::{AddBin, Conveyor, DropParts, Wait};
use crate::geometry;
use crate::grip::{Close, Open};
use crate::motion::{FollowOperator, Home, MoveTo, Target};
use crate::pick::Pick;
use crate::place::Place;
use crate::progress::Progress;
use crate::setup::Setup;
use crate::skill::{Skill, Station};
use crate::world::World;
use way::WayPorts;

/// What a leaf gets with each call.
pub type Context<'a, 'w> = Cx<'a, 'w, Station>;

/// Names that nodes use where no port says otherwise, see [`with_work`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkKeys {
    /// Key of the tree's own blackboard: name of the object it works at, empty
    /// for none.
    pub object: &'static str,
    /// Key of the tree's own blackboard: where that object was when it was aimed
    /// at (m).
    pub reference: &'static str,
    /// Beginning of the shared keys that say whose an object is.
    pub owners: &'static str,
    /// The zone that nodes work in.
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

/// All node types, for a cell. Names of objects, places and sensors that are
/// written in a file are checked when it is loaded.
pub fn library(setup: &Arc<Setup>) -> Library<Station> {
    with_work(skills(setup), setup, WorkKeys::default())
}

/// Adds the node types for arms that work side by side, and for trees with a
/// branch of their own for recoveries.
pub fn with_work(
    library: Library<Station>,
    setup: &Arc<Setup>,
    keys: WorkKeys,
) -> Library<Station> {
    zones::add(guarded::add(library, keys), setup, keys)
}

fn skills(setup: &Arc<Setup>) -> Library<Station> {
    let library = Library::default()
        .with(move_to(setup))
        .with(up())
        .with(plain(
            "Home",
            "Brings the joints to where they were at the start.",
            || Home,
        ))
        .with(plain(
            "Open",
            "Opens the gripper, or switches suction off.",
            || Open,
        ))
        .with(close(setup))
        .with(pick(setup))
        .with(place(setup))
        .with(plain(
            "FollowOperator",
            "Follows the operator's target and gripper requests; never ends.",
            || FollowOperator,
        ))
        .with(plain("AddBin", "Asks for the next bin.", || AddBin))
        .with(plain("DropParts", "Asks the dispenser for parts.", || {
            DropParts
        }))
        .with(conveyor())
        .with(stay())
        .with(fail());
    conditions::add(library, setup)
}

/// A name that a port is bound to: resolved when the file is loaded, or looked
/// up at every tick where it is in a key.
#[derive(Clone, Copy)]
enum Named {
    Index(usize),
    Key(In<Str>, fn(&Setup, &str) -> Option<usize>),
}

impl Named {
    fn get(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        match self {
            Self::Index(index) => Ok(Some(*index)),
            Self::Key(key, find) => Ok(find(cx.world.setup, cx.get(key)?.as_str())),
        }
    }
}

#[allow(clippy::result_large_err, reason = "happens at load, once")]
fn named(
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
fn object(binder: &mut Binder<'_>, setup: &Setup) -> Result<Named, BindError> {
    named(binder, "object", setup, Setup::object, |setup| {
        setup.objects.iter().map(|o| o.name.as_str()).collect()
    })
}

#[allow(clippy::result_large_err, reason = "happens at load, once")]
fn place_named(binder: &mut Binder<'_>, setup: &Setup) -> Result<Named, BindError> {
    named(binder, "place", setup, Setup::place, |setup| {
        setup.places.iter().map(|p| p.name.as_str()).collect()
    })
}

#[allow(clippy::result_large_err, reason = "happens at load, once")]
fn sensor(binder: &mut Binder<'_>, setup: &Setup) -> Result<Named, BindError> {
    named(binder, "sensor", setup, Setup::sensor, |setup| {
        setup.sensors.iter().map(String::as_str).collect()
    })
}

/// Whether a port was given, whose default is an empty text or no numbers.
fn is_given(binder: &Binder<'_>, port: &str) -> bool {
    match binder.bindings.get(port) {
        Some(Binding::Literal(behavior::Value::Text(text))) => !text.is_empty(),
        Some(Binding::Literal(behavior::Value::Numbers(list))) => !list.as_slice().is_empty(),
        Some(Binding::Key(..)) => true,
        _ => false,
    }
}

/// A leaf whose skill is made from its ports at every tick; `None` where an
/// object or a place does not exist, which fails.
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

/// `MoveTo`: a pose, an object, or a place.
fn move_to(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    let node_type = NodeType::new(
        "MoveTo",
        "Brings the TCP to an object, with an object in the gripper to the next \
         free slot of a place, or to a pose. Fails when that takes too long, when \
         the object moves away, or when the object in the gripper is lost.",
        move |binder| {
            let target = Where::bind(binder, &setup)?;
            let above = binder.input::<f64>("above_m")?;
            let timeout = binder.input::<f64>("timeout_s")?;
            let movement = binder.input::<f64>("move_tolerance_m")?;
            let way = WayPorts::bind(binder, &setup)?;
            Ok(Made(move |cx: &Context<'_, '_>| {
                let Some(skill) = target.skill(cx, cx.get(&above)?)? else {
                    return Ok(None);
                };
                Ok(Some(MoveTo {
                    timeout: seconds(cx.get(&timeout)?),
                    move_tolerance_m: cx.get(&movement)?,
                    way: way.get(cx)?,
                    ..skill
                }))
            }))
        },
    )
    .keywords(&["move", "reach", "go", "approach", "motion", "pose", "line"])
    .input_or("object", Str::EMPTY, "object to move to, or to bring")
    .input_or(
        "place",
        Str::EMPTY,
        "place to bring the object in the gripper to",
    )
    .input_or(
        "pose",
        Numbers::default(),
        "TCP x y z (m), or that and w x y z, world frame; straight down without",
    )
    .input_or(
        "above_m",
        0.0,
        "height above that (m); 0 is exact and straight",
    )
    .within(0.0, 2.0)
    .input_or(
        "move_tolerance_m",
        0.05,
        "fails when the object moved further in the plane (m)",
    )
    .within(1.0e-3, 10.0)
    .input_or("timeout_s", 10.0, "fails after this (s)")
    .within(0.1, 3600.0);
    way::ports(node_type)
}

/// What a `MoveTo` goes to.
#[derive(Clone, Copy)]
enum Where {
    Object(Named),
    Place(Named, Named),
    Pose(In<Numbers>),
}

impl Where {
    #[allow(clippy::result_large_err, reason = "happens at load, once")]
    fn bind(binder: &mut Binder<'_>, setup: &Setup) -> Result<Self, BindError> {
        let given = ["object", "place"].map(|port| is_given(binder, port));
        match given {
            [true, true] => Ok(Self::Place(
                object(binder, setup)?,
                place_named(binder, setup)?,
            )),
            [true, false] => Ok(Self::Object(object(binder, setup)?)),
            [false, true] => Err(BindError::Host(
                "MoveTo with a 'place' needs the 'object' it brings there".to_owned(),
            )),
            [false, false] => {
                let pose = binder.input::<Numbers>("pose")?;
                if let In::Literal(numbers) = pose
                    && !matches!(numbers.as_slice().len(), 3 | 7)
                {
                    return Err(BindError::Host(
                        "MoveTo needs an 'object', an 'object' and a 'place', or a 'pose' of 3 \
                         or 7 numbers"
                            .to_owned(),
                    ));
                }
                Ok(Self::Pose(pose))
            }
        }
    }

    fn skill(&self, cx: &Context<'_, '_>, above_m: f64) -> Result<Option<MoveTo>, Fault> {
        Ok(match self {
            Self::Object(object) => object.get(cx)?.map(|o| MoveTo::object(o, above_m)),
            Self::Place(object, place) => {
                let both = object.get(cx)?.zip(place.get(cx)?);
                both.map(|(object, place)| MoveTo::place(object, place, above_m))
            }
            Self::Pose(pose) => tcp_pose(cx.get(pose)?.as_slice(), cx.world).map(|mut pose| {
                pose.position[2] += above_m;
                MoveTo::new(Target::Pose(pose))
            }),
        })
    }
}

/// The pose that 3 or 7 numbers mean; straight down as the tool is turned now
/// without an orientation.
fn tcp_pose(numbers: &[f64], world: &World<'_>) -> Option<Pose> {
    match *numbers {
        [x, y, z] => Some(Pose {
            position: [x, y, z],
            orientation_wxyz: world.tool().down(0.0),
        }),
        [x, y, z, w, i, j, k] => {
            let unit = geometry::rotation([w, i, j, k]);
            Some(Pose {
                position: [x, y, z],
                orientation_wxyz: [unit.w, unit.i, unit.j, unit.k],
            })
        }
        _ => None,
    }
}

/// `Up`: straight up.
fn up() -> NodeType<Station> {
    NodeType::new(
        "Up",
        "Moves straight up from where the arm is. With 'holding' it keeps the \
         gripper closed, and fails when that object is lost.",
        |binder| {
            let by = binder.input::<f64>("by_m")?;
            let holding = binder.input::<Str>("holding")?;
            Ok(Made(move |cx: &Context<'_, '_>| {
                let skill = MoveTo::up(cx.get(&by)?);
                let name = cx.get(&holding)?;
                if name.is_empty() {
                    return Ok(Some(skill));
                }
                let object = cx.world.setup.object(name.as_str());
                Ok(object.map(|object| skill.holding(object)))
            }))
        },
    )
    .keywords(&["lift", "retract", "rise"])
    .input_or("by_m", 0.1, "how far (m)")
    .within(0.0, 2.0)
    .input_or(
        "holding",
        Str::EMPTY,
        "object that has to stay in the gripper",
    )
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
    .input_or("object", Str::EMPTY, "what has to be in the gripper then")
}

/// `Pick`.
fn pick(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "Pick",
        "Picks an object up from above: above it, down, close, lift. Succeeds at \
         once with an object that is in the gripper. Starts again when the object \
         moves; after too many failures in a row the job fails.",
        move |binder| {
            let object = object(binder, &setup)?;
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
    .input::<Str>("object", "the object")
    .input_or("clearance_m", 0.1, "height at which the tool travels (m)")
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
         across, down, open, up. Fails when it is lost or does not stay there; \
         after too many failures in a row the job fails.",
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
        "FailJob",
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
