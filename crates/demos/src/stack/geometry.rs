//! Where the TCP shall be in a phase, and which way the fingers point.

use std::f64::consts::FRAC_PI_2;

use ipc_types::Pose;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::phase::Phase;
use super::setup::StackSetup;
use robocell_task::job::Placement;

/// Turn of a cube about the vertical axis, within -45 and 45 degrees (rad): a
/// quarter turn of a cube changes nothing. It is read from the body axis that
/// lies flattest, so a cube on its side has one, too.
pub fn yaw(pose: &Pose) -> f64 {
    let [w, x, y, z] = pose.orientation_wxyz;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    let mut flattest = rotation * Vector3::x();
    for axis in [rotation * Vector3::y(), rotation * Vector3::z()] {
        if axis.z.abs() < flattest.z.abs() {
            flattest = axis;
        }
    }
    nearest_quarter(libm::atan2(flattest.y, flattest.x), 0.0)
}

/// Turn of a tool about the vertical axis (rad): where its x axis points.
pub fn tool_yaw(tcp: &Pose) -> f64 {
    let [w, x, y, z] = tcp.orientation_wxyz;
    let axis = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)) * Vector3::x();
    libm::atan2(axis.y, axis.x)
}

/// The angle equal to `angle` up to quarter turns that lies nearest to
/// `reference` (rad).
pub fn nearest_quarter(angle: f64, reference: f64) -> f64 {
    angle - ((angle - reference) / FRAC_PI_2).round() * FRAC_PI_2
}

/// Orientation of a tool that points straight down, turned by `yaw` about the
/// vertical axis; w x y z. With no turn it is (0, 1, 0, 0) and the fingers move
/// along the world's y axis.
pub fn straight_down(yaw: f64) -> [f64; 4] {
    [0.0, libm::cos(yaw / 2.0), libm::sin(yaw / 2.0), 0.0]
}

/// The pose of the TCP in `phase`: above `place` by the clearance while it
/// travels, at it otherwise, always by the grasp offset of the cell file. The
/// demos' offset of -0.03 m along the tool's y belongs to another tool frame.
pub fn tcp_target(setup: &StackSetup, phase: Phase, place: Placement) -> Pose {
    let height = match phase {
        Phase::PreGrasp | Phase::Lift | Phase::Transport | Phase::Retract => setup.spec.clearance_m,
        Phase::Approach | Phase::Grasp | Phase::Lower | Phase::Release => 0.0,
    };
    let centre = Vector3::from(place.position) + Vector3::from(setup.spec.grasp_offset_m);
    Pose {
        position: (centre + Vector3::z() * height).into(),
        orientation_wxyz: straight_down(place.yaw),
    }
}

/// A destination nearer than this in the plane is beside the pick-up (m).
const BESIDE_M: f64 = 0.2;

/// What LIFT rises above: the pick-up, as in the demos, or the height of a
/// higher destination right beside it, since a cube that lies at the foot of
/// the stack would knock it over on a slanted way up.
pub fn lift_place(pickup: Placement, destination: Placement) -> Placement {
    let beside = plane_distance(pickup.position.into(), destination.position.into()) < BESIDE_M;
    let [x, y, z] = pickup.position;
    let height = if beside {
        z.max(destination.position[2])
    } else {
        z
    };
    Placement {
        position: [x, y, height],
        ..pickup
    }
}

/// How near the TCP has to come (m). The demos know one tolerance, 0.08 m,
/// wider than a cube; where the fingers meet a cube ours is finer.
pub fn tolerance(setup: &StackSetup, phase: Phase) -> f64 {
    match phase {
        Phase::Approach | Phase::Grasp | Phase::Lower | Phase::Release => {
            setup.spec.precise_tolerance_m
        }
        Phase::PreGrasp | Phase::Lift | Phase::Transport | Phase::Retract => {
            setup.spec.travel_tolerance_m
        }
    }
}

/// Angle between two orientations (rad), 0 to pi.
pub fn angle_between(a: [f64; 4], b: [f64; 4]) -> f64 {
    let dot: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    2.0 * libm::acos(dot.abs().min(1.0))
}

/// Distance in the horizontal plane (m).
pub fn plane_distance(a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    (a.xy() - b.xy()).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(rotation: UnitQuaternion<f64>) -> Pose {
        let q = rotation.quaternion();
        Pose {
            position: [0.0; 3],
            orientation_wxyz: [q.w, q.i, q.j, q.k],
        }
    }

    #[test]
    fn yaw_is_the_same_on_every_side_of_a_cube() {
        for degrees in [-44.0_f64, -10.0, 0.0, 3.0, 44.0] {
            let yaw_rad = degrees.to_radians();
            for (roll, pitch, turns) in [
                (0.0, 0.0, 0.0),
                (1.0, 0.0, 1.0),
                (0.0, 1.0, 2.0),
                (2.0, 1.0, 3.0),
            ] {
                let turned =
                    UnitQuaternion::from_euler_angles(0.0, 0.0, yaw_rad + turns * FRAC_PI_2);
                let lying =
                    UnitQuaternion::from_euler_angles(roll * FRAC_PI_2, pitch * FRAC_PI_2, 0.0);
                let seen = yaw(&pose(turned * lying));
                assert!((seen - yaw_rad).abs() < 1e-9, "{degrees} deg: {seen}");
            }
        }
    }

    #[test]
    fn a_quarter_is_chosen_near_the_reference() {
        assert!((nearest_quarter(0.9, 0.0) - (0.9 - FRAC_PI_2)).abs() < 1e-12);
        assert!((nearest_quarter(0.9, 0.7) - 0.9).abs() < 1e-12);
        assert!((nearest_quarter(-0.1, FRAC_PI_2) - (FRAC_PI_2 - 0.1)).abs() < 1e-12);
    }

    #[test]
    fn the_tool_points_down_whatever_the_yaw() {
        assert_eq!(straight_down(0.0), [0.0, 1.0, 0.0, 0.0]);
        let [w, x, y, z] = straight_down(0.3);
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        assert!((rotation * Vector3::z() + Vector3::z()).norm() < 1e-12);
        let turned = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.3);
        let flat = straight_down(0.0);
        let flat =
            UnitQuaternion::new_normalize(Quaternion::new(flat[0], flat[1], flat[2], flat[3]));
        assert!((turned * flat).angle_to(&rotation) < 1e-7);
        assert!((angle_between(straight_down(0.0), straight_down(0.3)) - 0.3).abs() < 1e-9);
    }
}
