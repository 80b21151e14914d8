//! Planning of a grasp as `Pick` does it: candidates among 160 objects, and the inverse kinematics
//! of the best ones.

use std::error::Error;
use std::hint::black_box;

use cell_model::{ArmSpec, Cell, Data, Shape};
use cell_rt::monotonic_ns;
use cell_sim::eval;
use grasp::{Body, Gripper, Reach, Scene, first_grasps};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::rounds::row;
use crate::report::Row;

/// Objects of the scene, in rows.
const OBJECTS: [usize; 2] = [10, 16];
/// From one of them to the next (m): neighbours leave room for the hand of some.
const PITCH_M: f64 = 0.09;
/// Each object is planned this often.
const ROUNDS: usize = 20;

/// Time of a plan for each object that the arm reaches, with free candidates or without.
pub(crate) fn rows() -> Result<Vec<Row>, Box<dyn Error>> {
    let cell: Cell = eval::template("cube", "ifelse").load_cell_from(&Data::checkout())?;
    let arm = cell.arms.first().ok_or("the cell has no arm")?;
    let gripper = Gripper::of(&arm.robot).ok_or("the arm has no gripper")?;
    let mut scene = Scene::of(&cell);
    scene.objects = objects();
    let mut reach = Reach::of(arm).ok_or("the arm has no kinematics")?;
    let mut samples = Vec::new();
    for round in 0..=ROUNDS {
        for object in 0..scene.objects.len() {
            let began_ns = monotonic_ns();
            plan(&gripper, &scene, object, (arm, &mut reach));
            let took_ns = monotonic_ns().saturating_sub(began_ns);
            // The first round fills the caches.
            if round > 0 {
                samples.push(took_ns as f64);
            }
        }
    }
    Ok(vec![row("grasp planning", samples)])
}

fn plan(gripper: &Gripper, scene: &Scene, object: usize, (arm, reach): (&ArmSpec, &mut Reach)) {
    // The scene of a decision is a copy with the observed poses.
    let scene = scene.clone();
    let mut refused = 0;
    let found = first_grasps(gripper, &scene, (object, None), 1, |tcp| {
        let reaches = refused < 3 && reach.reaches_from(&arm.home, tcp);
        refused += usize::from(!reaches);
        reaches
    });
    black_box(found.best());
}

/// Boxes, cylinders and plates of several sizes, each turned by another angle.
fn objects() -> Vec<Body> {
    let [rows, columns] = OBJECTS;
    let body = |index: usize| {
        let (row, column) = (index / columns, index % columns);
        let height = [0.02, 0.04, 0.08][index % 3];
        let shape = match index % 4 {
            0 => Shape::Cylinder {
                radius_m: 0.02,
                height_m: height,
            },
            1 => Shape::Box {
                size_m: [0.03, 0.06, height],
            },
            _ => Shape::Box {
                size_m: [0.04, 0.04, height],
            },
        };
        let x = 0.25 + PITCH_M * row as f64;
        let y = PITCH_M * (column as f64 - 0.5 * columns as f64);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.3 * index as f64);
        let pose = Isometry3::from_parts(Translation3::new(x, y, 0.5 * height), turn);
        Body::new(&format!("object_{index}"), &shape, Some(pose))
    };
    (0..rows * columns).map(body).collect()
}
