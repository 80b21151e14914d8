//! The node types of this demo. Those that do more than one check have a file of their own.
#![allow(clippy::result_large_err, reason = "happens at load, once")]

mod acquire;
mod recover;
mod reset;

use std::sync::Arc;

use behavior::Status;
use behavior::board::{Fault, In};
use behavior::tree::check::CONDITION;
use behavior::tree::{BindError, Binder, Leaf, Library, NodeType};
use robocell_skills::nodes::Context;
use robocell_skills::{Owner, Station};

use super::notes::Notes;
use super::setup::Pyramid;

/// Adds the node types, for a job.
pub(super) fn add(library: Library<Station>, job: &Arc<Pyramid>) -> Library<Station> {
    library
        .with(reset::node_type(job))
        .with(acquire::node_type(job))
        .with(recover::node_type(job))
        .with(calibrate(job))
        .with(mark_placed(job))
        .with(check_complete(job))
}

/// A node type that is created with access to the notes of its tree.
fn node_type<L: Leaf<Station>>(
    (name, doc): (&'static str, &'static str),
    job: &Arc<Pyramid>,
    make: fn(Notes, &mut Binder<'_>) -> Result<L, BindError>,
) -> NodeType<Station> {
    let job = Arc::clone(job);
    NodeType::new(name, doc, move |binder| {
        make(Notes::bind(&job, binder)?, binder)
    })
}

/// A node without state.
struct Plain<F> {
    notes: Notes,
    run: F,
}

impl<F> Leaf<Station> for Plain<F>
where
    F: Fn(&Notes, &mut Context<'_, '_>) -> Result<Status, Fault> + Send + 'static,
{
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        (self.run)(&self.notes, cx)
    }
}

fn answer(holds: bool) -> Status {
    if holds {
        Status::Success
    } else {
        Status::Failure
    }
}

fn calibrate(job: &Arc<Pyramid>) -> NodeType<Station> {
    let about = (
        "CalibratePlaceTargets",
        "Compares the stack with the observed cubes, and shifts and turns the targets \
         of the place by the pose of the cube in the gripper.",
    );
    node_type(about, job, |notes, _| {
        Ok(Plain {
            notes,
            run: |notes: &Notes, cx: &mut Context<'_, '_>| {
                let current = notes.current(cx)?;
                // Nothing to calibrate: the cube was lost or exchanged since the pick-up.
                let Some(cube) = current.filter(|cube| cx.world.held() == Some(*cube)) else {
                    let why = format_args!("no cube to be placed is in the gripper");
                    notes.recovery.request(cx, why)?;
                    return Ok(Status::Running);
                };
                let stack = notes.compare(cx)?;
                Ok(answer(notes.calibrate(cx, cube, stack)?))
            },
        })
    })
    .aliases(&["FrankaCalibratePlaceTargets"])
    .keywords(&["offset", "hand", "place"])
}

/// Adds the port of the nodes that count cubes.
fn counting(node_type: NodeType<Station>) -> NodeType<Station> {
    node_type
        .input_or("required_count", 3_i64, "cubes of a complete stack")
        .within(1.0, 16.0)
}

fn check_complete(job: &Arc<Pyramid>) -> NodeType<Station> {
    let about = (
        "CheckStackComplete",
        "Compares the arm's stack with the observed cubes, and succeeds when it has the \
         required number of cubes and no other arm needs one that only this arm reaches.",
    );
    counting(node_type(about, job, |notes, binder| {
        let required = binder.input::<i64>("required_count")?;
        Ok(Plain {
            notes,
            run: move |notes: &Notes, cx: &mut Context<'_, '_>| {
                let stack = notes.compare(cx)?;
                let complete = i64::from(stack.len()) >= cx.get(&required)?;
                notes.set_complete(cx, complete)?;
                Ok(answer(complete && !notes.look(cx).helps()))
            },
        })
    }))
    .aliases(&["FrankaCheckStackComplete"])
    .keywords(&[CONDITION, "done", "finished", "count"])
}

fn mark_placed(job: &Arc<Pyramid>) -> NodeType<Station> {
    let about = (
        "MarkCubePlaced",
        "Adds the cube to the arm's stack if it is seen there, and notes when the stack \
         is complete. A repetition changes nothing.",
    );
    counting(node_type(about, job, |notes, binder| {
        let required = binder.input::<i64>("required_count")?;
        Ok(Plain {
            notes,
            run: move |notes: &Notes, cx: &mut Context<'_, '_>| mark(notes, &required, cx),
        })
    }))
    .aliases(&["FrankaMarkCubePlaced"])
    .keywords(&["count", "done", "placed"])
}

fn mark(notes: &Notes, required: &In<i64>, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
    let Some(cube) = notes.current(cx)? else {
        return Ok(Status::Failure);
    };
    let (goal, aside) = notes.goal(cx)?;
    // Observed, not assumed: a cube that fell off must not be counted.
    let tolerance_m = if aside {
        notes.task().goal_tolerance_m
    } else {
        notes.look(cx).tolerance(notes.stack(cx)?.len() as usize)
    };
    if !cx.world.is_at(cube, goal, tolerance_m) {
        return Ok(Status::Failure);
    }
    let (arm, name) = (notes.me, cx.world.setup.object_name(cube));
    if aside {
        notes.set_owner(cx, cube, Owner::Available)?;
        let out = &mut *cx.world.out;
        out.log(format_args!("[aside] {arm}: {name} is out of the way"));
    } else {
        // A set, not a counter: the node may run twice for one cube after a restart, and counts
        // it once.
        let count = notes.add_to_stack(cx, cube)?.len();
        if i64::from(count) >= cx.get(required)? {
            notes.set_complete(cx, true)?;
        }
        let out = &mut *cx.world.out;
        out.log(format_args!("[placed] {arm}: {name} is number {count}"));
    }
    notes.set_current(cx, None)?;
    notes.recovery.clear(cx)?;
    Ok(Status::Success)
}
