//! The arm keeps away from an obstacle: parry's distances are the oracle, at
//! the joints that were measured, not those the controller believes in.

use cell_model::cells::cell::FixtureSpec;
use cell_model::{Cell, Data, Robot, Shape};
use cell_sim::{OneProcess, eval::template};
use nalgebra::{Isometry3, Point3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::distance;
use parry3d_f64::shape::{Ball, Cuboid};

/// A low wall across the way from the cubes to the stack.
const WALL: &str = r#"
[[fixture]]
name = "wall"
shape = { kind = "box", size_m = [0.4, 0.04, 0.14] }
position_m = [0.5, -0.05, 0.07]
friction = 0.5
obstacle = true
colour = [0.5, 0.5, 0.5]
"#;

fn parry(isometry: &Isometry3<f64>) -> Pose {
    let (p, q) = (isometry.translation, isometry.rotation);
    Pose::from_parts(
        Vector::new(p.x, p.y, p.z),
        Rotation::from_xyzw(q.i, q.j, q.k, q.w),
    )
}

/// Smallest distance of a collision sphere of the robot from the wall (m).
fn clearance(robot: &Robot, measured: &[f64], wall: &FixtureSpec) -> f64 {
    let Shape::Box { size_m: [x, y, z] } = wall.shape else {
        panic!("the wall is a box")
    };
    let cuboid = Cuboid::new(Vector::new(0.5 * x, 0.5 * y, 0.5 * z));
    // Fingers where the motion policies take them to be.
    let mut positions = robot.fixed_joint_positions.clone();
    for (&joint, position) in robot.arm_joints.iter().zip(measured) {
        positions[joint] = *position;
    }
    let spheres = robot.spheres.iter().map(|sphere| {
        let frame = robot
            .chain
            .frame_index(&sphere.frame)
            .expect("a frame of the robot");
        let pose = robot
            .frame_pose(frame, &positions)
            .expect("a frame of the robot");
        let center = pose * Point3::from(sphere.center);
        let ball = Pose::from_parts(
            Vector::new(center.x, center.y, center.z),
            Rotation::IDENTITY,
        );
        distance(
            &ball,
            &Ball::new(sphere.radius),
            &parry(&wall.pose),
            &cuboid,
        )
        .expect("both are simple shapes")
        .distance
    });
    spheres.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_wall_in_the_way_is_never_touched_and_the_reported_clearance_is_true() {
    let data = Data::checkout();
    let text = data
        .read("cells/franka-stack.toml")
        .expect("the built-in cell");
    let text = text.replacen("\n[task]\n", &format!("{WALL}\n[task]\n"), 1);
    let cell =
        Cell::from_text(&data, "franka-stack", "walled.toml", &text, 4, None).expect("a cell");
    let (robot, wall) = (
        cell.arms[0].robot.clone(),
        cell.obstacles().next().expect("the wall").clone(),
    );
    let mut sim = OneProcess::new(&demos::policies(), &template("franka-stack", "fsm"), cell)
        .expect("a cell that runs");
    let (mut nearest, mut largest_gap) = (f64::INFINITY, 0.0_f64);
    let mut ticks = 0_u64;
    while sim.tick().expect("a tick") {
        ticks += 1;
        assert!(ticks < 120_000, "the job ends");
        if !ticks.is_multiple_of(20) {
            continue;
        }
        let arm = &sim.state().arms[0];
        let n = arm.joint_count as usize;
        let true_clearance = clearance(&robot, &arm.joint_positions[..n], &wall);
        nearest = nearest.min(true_clearance);
        // A reported clearance is of the setpoint one cycle before.
        let reported = sim.statuses()[0].min_clearance;
        largest_gap = largest_gap.max((reported - true_clearance).abs());
    }
    assert_eq!(sim.decision().placed_count, 4);
    assert!(nearest > 0.005, "{nearest} m");
    assert!(nearest < 0.10, "the wall was in the way: {nearest} m");
    assert!(
        largest_gap < 0.005,
        "reported and true differ by {largest_gap} m"
    );
}
