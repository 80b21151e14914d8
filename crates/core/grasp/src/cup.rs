//! Candidates for a suction cup.

use cell_model::Shape;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::candidate::{Approach, Candidate, Depth, Exclusion};
use crate::gripper::Cup;
use crate::scene::{Body, Scene};

/// A face smaller than the cup by no more than this is large enough (m).
const ROUNDING_M: f64 = 1.0e-6;
/// Clearance of the tool to fixtures and objects, and to other arms (m).
const CLEARANCE_M: f64 = 0.002;
const ARM_CLEARANCE_M: f64 = 0.01;
/// Distances before the grasp at which the tool is checked (m).
const WAY_M: [f64; 4] = [0.0, 0.03, 0.06, 0.1];
/// A face whose normal is this far from the vertical is level (cosine of 10 degrees).
const LEVEL: f64 = 0.985;

/// A flat face: its centre, its normal, and the radius of the largest circle on it (m).
struct Face {
    centre: Vector3<f64>,
    normal: Vector3<f64>,
    radius_m: f64,
}

/// The candidates for `object`, which is at `pose`; `tool` is the present pose of the TCP. They are
/// few, so `add` gets all at once.
pub(crate) fn candidates(
    cup: &Cup,
    scene: &Scene,
    (object, pose): (&Body, &Isometry3<f64>),
    tool: Option<&Isometry3<f64>>,
    mut add: impl FnMut(Vec<Candidate>, f64) -> bool,
) {
    let faces = faces(&object.shape);
    let mut all = Vec::new();
    for face in faces {
        let normal = pose.rotation * face.normal;
        let approach = match normal.z {
            z if z > LEVEL => Approach::Above,
            z if z > 0.3 => Approach::Oblique,
            z if z > -0.1 => Approach::Side,
            _ => continue,
        };
        let centre = pose * nalgebra::Point3::from(face.centre);
        let present = tool.map_or_else(UnitQuaternion::identity, |tool| tool.rotation);
        let tcp = Isometry3::from_parts(
            Translation3::from(centre.coords + normal * cup.gap_m),
            turned(present, &(present * cup.axis), &-normal),
        );
        // The more level the face, the better.
        let cost = 2.0 * (1.0 - normal.z);
        let cup_m = cup.radius_m;
        let face_m = face.radius_m;
        let excluded = (face_m < cup_m - ROUNDING_M)
            .then_some(Exclusion::CupLargerThanFace { face_m, cup_m })
            .or_else(|| blocked(cup, scene, object, &tcp));
        all.push(Candidate {
            tcp,
            approach,
            depth: Depth::Face,
            width_m: 2.0 * face_m,
            opening_m: 0.0,
            cost: cost + 0.1 * present.angle_to(&tcp.rotation),
            excluded,
        });
    }
    add(all, f64::INFINITY);
}

/// `rotation`, turned the short way so that `from` points along `to`.
fn turned(
    rotation: UnitQuaternion<f64>,
    from: &Vector3<f64>,
    to: &Vector3<f64>,
) -> UnitQuaternion<f64> {
    let turn = UnitQuaternion::rotation_between(from, to);
    // Opposite directions have no shortest turn: any is right.
    let turn = turn.unwrap_or_else(|| {
        let across = Vector3::x_axis().cross(from);
        let across = if across.norm() > 0.1 {
            across
        } else {
            Vector3::y()
        };
        UnitQuaternion::from_axis_angle(
            &nalgebra::Unit::new_normalize(across),
            std::f64::consts::PI,
        )
    });
    turn * rotation
}

/// The faces that a cup can hold; round sides are none.
fn faces(shape: &Shape) -> Vec<Face> {
    let face = |centre: Vector3<f64>, normal: Vector3<f64>, radius_m| Face {
        centre,
        normal,
        radius_m,
    };
    match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => {
            let half = Vector3::from(size_m) * 0.5;
            let mut all = Vec::new();
            for axis in 0..3 {
                let others = (half[(axis + 1) % 3], half[(axis + 2) % 3]);
                for sign in [1.0, -1.0] {
                    let mut normal = Vector3::zeros();
                    normal[axis] = sign;
                    all.push(face(normal * half[axis], normal, others.0.min(others.1)));
                }
            }
            if let Shape::Bin { wall_m, .. } = *shape {
                // Its open side has no face; the cup holds its floor from inside.
                let floor = &mut all[4];
                floor.centre.z = wall_m - half.z;
                floor.radius_m -= wall_m;
            }
            all
        }
        Shape::Cylinder { radius_m, height_m } => [1.0, -1.0]
            .map(|sign| {
                let normal = Vector3::z() * sign;
                face(normal * (0.5 * height_m), normal, radius_m)
            })
            .into(),
        Shape::Sphere { radius_m } | Shape::Capsule { radius_m, .. } => {
            // A point of a round side, so that the refusal says how large a face is missing.
            vec![face(Vector3::z() * radius_m, Vector3::z(), 0.0)]
        }
    }
}

/// What the tool would touch on its way to `tcp`.
pub(crate) fn blocked(
    cup: &Cup,
    scene: &Scene,
    object: &Body,
    tcp: &Isometry3<f64>,
) -> Option<Exclusion> {
    let back = tcp.rotation * -cup.axis;
    WAY_M.iter().find_map(|off| {
        let at = Translation3::from(back * *off) * tcp;
        let margins = (CLEARANCE_M, CLEARANCE_M, ARM_CLEARANCE_M);
        scene.touched(object, margins, |body, margin| {
            body.is_near(&cup.body, &at, margin)
        })
    })
}
