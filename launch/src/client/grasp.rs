//! `robocell grasp`: the grasps of an object as it is now, and what excludes the others.

use cell_model::Cell;
use grasp::{Candidate, Grasps, Gripper, Reach, Scene, grasps};
use ipc_types::WorldState;
use ipc_types::world::OBJECT_ENABLED;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::Failure;

use super::Session;
use super::columns::{Column, table, terminal_width};
use super::follow::Follower;
use super::operate::object_index;
use super::scene::Place;
use crate::cli::GraspArgs;
use crate::{output, say};

/// The grasps of an object.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct GraspReport {
    arm: String,
    object: String,
    /// Best first; those that are excluded are last.
    candidates: Vec<GraspRow>,
    /// Why there is none: `too_wide`, `too_thin`, `cup_larger_than_face`, `no_room_for_fingers`,
    /// `blocked_by_fixture`, `blocked_by_object`, `blocked_by_arm` or `object_out_of_reach`.
    reason: Option<&'static str>,
    /// The same with names and numbers.
    message: Option<String>,
}

/// A candidate.
#[derive(Debug, Serialize, JsonSchema)]
struct GraspRow {
    /// `above`, `oblique` or `side`.
    approach: &'static str,
    /// `centre`, `low`, `upper part` or `face`.
    depth: &'static str,
    /// TCP in the world frame.
    tcp: Place,
    /// Turn of the direction in which the fingers close, about the vertical (rad, 0 to pi).
    yaw_rad: f64,
    /// Width of the object between the fingers, of the face for a cup (m).
    width_m: f64,
    /// The smaller, the better.
    cost: f64,
    /// As `reason` of the whole; missing for a grasp.
    excluded: Option<&'static str>,
    /// The same with names and numbers.
    why: Option<String>,
}

/// `robocell grasp OBJECT`.
pub(crate) fn grasp(args: &GraspArgs) -> Result<(), Failure> {
    let session = Session::of(&args.of.cell.cell)?;
    let bus = session.join()?;
    let state = Follower::new(&session, &bus)?.now()?;
    let cell = session.load_cell()?;
    let object = object_index(&cell, &args.object)?;
    let arm = args.of.arm as usize;
    let found = found(&cell, &state, object, arm)?;
    let report = report(&cell, object, arm, &found);
    if args.json {
        return output::print(&report);
    }
    print(&report);
    Ok(())
}

/// All grasps of an object by an arm, in the scene of `state`.
fn found(cell: &Cell, state: &WorldState, object: usize, arm: usize) -> Result<Grasps, Failure> {
    let spec = cell.arms.get(arm);
    let spec = spec.ok_or_else(|| {
        let count = cell.arms.len();
        Failure::configuration(format!("there is no arm {arm}; this cell has {count}"))
    })?;
    let gripper = Gripper::of(&spec.robot);
    let gripper = gripper
        .ok_or_else(|| Failure::configuration(format!("arm '{}' has no gripper", spec.name)))?;
    let mut scene = Scene::of(cell);
    for (body, seen) in scene.objects.iter_mut().zip(state.objects()) {
        let is_here = seen.flags & OBJECT_ENABLED != 0;
        body.pose = is_here.then(|| isometry(&seen.pose));
    }
    for (other, spec) in cell
        .arms
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != arm)
    {
        if let Some(seen) = state.arms().get(other) {
            let count = seen.joint_count as usize;
            scene.add_arm(spec, seen.joint_positions.get(..count).unwrap_or_default());
        }
    }
    let tool = state.arms().get(arm).map(|seen| isometry(&seen.tcp));
    let mut found = grasps(&gripper, &scene, object, tool.as_ref());
    // An arm whose files its controller refuses does not run.
    if let Some(mut reach) = Reach::of(spec) {
        found.ask_reach(|tcp| reach.reaches(tcp));
    }
    Ok(found)
}

fn isometry(pose: &ipc_types::Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.orientation_wxyz;
    Isometry3::from_parts(
        Translation3::from(pose.position),
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
    )
}

fn report(cell: &Cell, object: usize, arm: usize, found: &Grasps) -> GraspReport {
    let name = cell.objects.get(object).map(|object| object.name.clone());
    let refusal = found.refusal();
    let missing = found.candidates.is_empty();
    let absent = missing.then(|| "the object is not in the cell".to_owned());
    GraspReport {
        arm: cell
            .arms
            .get(arm)
            .map_or_else(String::new, |arm| arm.name.clone()),
        object: name.unwrap_or_default(),
        candidates: found.candidates.iter().map(row).collect(),
        reason: refusal.map(grasp::Exclusion::reason),
        message: refusal.map(ToString::to_string).or(absent),
    }
}

fn row(of: &Candidate) -> GraspRow {
    let rotation = of.tcp.rotation;
    let across = rotation * Vector3::y();
    GraspRow {
        approach: of.approach.name(),
        depth: of.depth.name(),
        tcp: Place::from(&ipc_types::Pose {
            position: of.tcp.translation.vector.into(),
            orientation_wxyz: [rotation.w, rotation.i, rotation.j, rotation.k],
        }),
        yaw_rad: across.y.atan2(across.x).rem_euclid(std::f64::consts::PI),
        width_m: of.width_m,
        cost: of.cost,
        excluded: of.excluded.as_ref().map(grasp::Exclusion::reason),
        why: of.excluded.as_ref().map(ToString::to_string),
    }
}

fn print(report: &GraspReport) {
    let all = &report.candidates;
    let free = all.iter().filter(|of| of.excluded.is_none()).count();
    say::line(format_args!(
        "{} by {}: {free} of {} candidates",
        report.object,
        report.arm,
        all.len()
    ));
    if let (Some(reason), Some(message)) = (report.reason, &report.message) {
        say::line(format_args!("no grasp ({reason}): {message}"));
    }
    let column = |title, text, rank| Column { title, rank, text };
    let columns = [
        column("from", true, 0),
        column("at", true, 0),
        column("x y z m", true, 0),
        column("yaw deg", false, 1),
        column("width mm", false, 2),
        column("", true, 0),
    ];
    let rows: Vec<Vec<String>> = all.iter().enumerate().map(cells).collect();
    for line in table(&columns, &rows, terminal_width()) {
        say::line(line);
    }
}

fn cells((index, of): (usize, &GraspRow)) -> Vec<String> {
    let [x, y, z] = of.tcp.position;
    let chosen = if index == 0 { "chosen" } else { "" };
    let why = of.why.clone().unwrap_or_else(|| chosen.to_owned());
    vec![
        of.approach.to_owned(),
        of.depth.to_owned(),
        format!("{x:.3} {y:.3} {z:.3}"),
        format!("{:.0}", of.yaw_rad.to_degrees()),
        format!("{:.1}", 1.0e3 * of.width_m),
        why,
    ]
}
