//! Poses of the cup at a bin, and of the tool with the bin in its place.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// Cosine of 15 degrees: a bin that leans by more is not in its place.
const LEVEL: f64 = 0.966;
/// Cosine of 40 degrees: a bin that leans by more cannot be gripped. The cup is turned with it.
const TILTED: f64 = 0.766;

/// Measures of a bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BinShape {
    /// Outer edge lengths (m); the long side is that along x.
    pub(super) size: Vector3<f64>,
    /// Thickness of its floor (m).
    pub(super) wall: f64,
}

/// Orientation of a bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lie {
    /// It opens upwards, and may lean a little.
    Upright,
    /// It opens downwards, and may lean a little.
    UpsideDown,
    /// On a side, or leaning further.
    Tilted,
}

/// Orientation of a bin at `pose`.
pub(super) fn lie(pose: &Isometry3<f64>) -> Lie {
    let up = (pose.rotation * Vector3::z()).z;
    if up > TILTED {
        Lie::Upright
    } else if up < -TILTED {
        Lie::UpsideDown
    } else {
        Lie::Tilted
    }
}

/// Whether a bin at `pose` opens upwards and is level.
pub(super) fn is_level(pose: &Isometry3<f64>) -> bool {
    (pose.rotation * Vector3::z()).z > LEVEL
}

/// Whether a bin at `pose` opens downwards, swinging or not.
pub(super) fn opens_down(pose: &Isometry3<f64>) -> bool {
    (pose.rotation * Vector3::z()).z < 0.0
}

/// The pose of the tool where the cup, `gap` (m) away, faces the centre of the bin's floor:
/// from the inside if the bin opens upwards, from the outside if it is upside down. `None` for
/// one that is tilted. Of the possible turns about the approach, the one nearest to `tool`.
///
/// A bin that has to be turned over is gripped such that its long side is level at `flip`, so
/// that it tilts about that side only.
pub(super) fn grasp(
    pose: &Isometry3<f64>,
    shape: &BinShape,
    gap: f64,
    tool: &UnitQuaternion<f64>,
    flip: &UnitQuaternion<f64>,
) -> Option<Isometry3<f64>> {
    let axis = |v: Vector3<f64>| pose.rotation * v;
    let (height, turns) = match lie(pose) {
        Lie::Tilted => return None,
        Lie::Upright => {
            let down = -axis(Vector3::z());
            // Any of the four sides does: an upright bin is only carried.
            let sides = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()];
            let turns = sides.map(|side| frame(down, Vector3::y(), axis(side)));
            (shape.wall + gap - 0.5 * shape.size.z, turns)
        }
        Lie::UpsideDown => {
            let down = axis(Vector3::z());
            // Along its long side only, for the tilt in the jig.
            let long = level_in_tool(flip);
            let one = frame(down, long, axis(Vector3::x()));
            let other = frame(down, long, axis(-Vector3::x()));
            (-(gap + 0.5 * shape.size.z), [one, other, one, other])
        }
    };
    let position = pose.translation.vector + axis(Vector3::z() * height);
    let rotation = nearest(&turns, tool)?;
    Some(Isometry3::from_parts(
        Translation3::from(position),
        rotation,
    ))
}

/// The pose of the tool that puts a bin, held at `grip` (the bin in the tool's frame), into
/// `slot`; of the two possible turns of the bin, the one nearer to `tool`.
pub(super) fn place(
    slot: &Isometry3<f64>,
    grip: &Isometry3<f64>,
    tool: &UnitQuaternion<f64>,
) -> Isometry3<f64> {
    let half_turn = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(0.0, 0.0, 0.0, 1.0));
    let targets = [*slot, slot * half_turn].map(|bin| bin * grip.inverse());
    let [one, other] = targets;
    if one.rotation.angle_to(tool) <= other.rotation.angle_to(tool) {
        one
    } else {
        other
    }
}

/// The direction, in the tool's frame and across its axis, that is level in the world at
/// `flip`.
fn level_in_tool(flip: &UnitQuaternion<f64>) -> Vector3<f64> {
    let level = Vector3::z().cross(&(flip * Vector3::x()));
    // A tool that points straight up or down has no such direction; any will do.
    let level = level.try_normalize(1.0e-6).unwrap_or_else(Vector3::y);
    flip.inverse() * level
}

/// The rotation that maps the tool's x axis to `approach`, and `across`, a direction in the
/// tool's frame at right angles to x, to `side`.
fn frame(approach: Vector3<f64>, across: Vector3<f64>, side: Vector3<f64>) -> UnitQuaternion<f64> {
    let world = Matrix3::from_columns(&[approach, side, approach.cross(&side)]);
    let own = Matrix3::from_columns(&[Vector3::x(), across, Vector3::x().cross(&across)]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(world * own.transpose()))
}

fn nearest(turns: &[UnitQuaternion<f64>], to: &UnitQuaternion<f64>) -> Option<UnitQuaternion<f64>> {
    let nearer = |a: &&UnitQuaternion<f64>, b: &&UnitQuaternion<f64>| {
        a.angle_to(to).total_cmp(&b.angle_to(to))
    };
    turns.iter().min_by(nearer).copied()
}
