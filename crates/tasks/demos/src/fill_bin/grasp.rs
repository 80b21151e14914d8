//! The spot at which a bin can be gripped.

use ipc_types::Pose;
use nalgebra::{Isometry3, Point3, Vector3};

use super::job::Turn;
use robocell_skills::{geometry, pose};

/// A side of the bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// The inside of its floor.
    Floor,
    /// The outside of its floor.
    Bottom,
    /// The outside of a wall.
    Wall,
}

impl Side {
    /// Name for the log.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Floor => "inside, on its floor",
            Self::Bottom => "upside down, on its bottom",
            Self::Wall => "on its side, on a wall",
        }
    }
}

/// A spot that suction can hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grasp {
    pub(super) side: Side,
    /// Pose of the cup at the spot, with x into the surface.
    pub(super) at: Pose,
}

/// Reason for which no spot was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NoGrasp {
    /// The bin fell out of the cell.
    Lost,
    /// Too far away, or too near to the arm's base.
    OutOfReach,
    /// No side is level enough.
    NoSurface,
    /// The bin is upright, and parts cover its floor.
    Covered,
}

/// Centre and outward direction of a side, in the frame of the bin.
struct Face {
    side: Side,
    middle: Point3<f64>,
    normal: Vector3<f64>,
}

/// Finds the spot to grip the bin at: on the side that faces up most.
pub(super) fn find(turn: &Turn<'_>) -> Result<Grasp, NoGrasp> {
    let bin = turn.seen(turn.of.bin).ok_or(NoGrasp::Lost)?.pose;
    let task = &turn.of.task;
    let centre = bin.translation.vector - turn.of.base.translation.vector;
    let distance = centre.xy().norm();
    let [near, far] = task.reach_m;
    // In the plane only, before anything else: outside of this ring no side can be gripped, and
    // its reason is the more useful one.
    if distance < near || distance > far {
        return Err(NoGrasp::OutOfReach);
    }
    let up = |face: &Face| (bin.rotation * face.normal).z;
    let faces = faces(turn);
    let best = faces.iter().max_by(|a, b| up(a).total_cmp(&up(b)));
    let face = best.filter(|face| up(face) > libm::cos(task.max_tilt_rad));
    let face = face.ok_or(NoGrasp::NoSurface)?;
    // Walls and bottom are free of parts; only the floor has to be searched for a free spot.
    let spot = if face.side == Side::Floor {
        free_spot(turn, &bin, face).ok_or(NoGrasp::Covered)?
    } else {
        face.middle
    };
    let inward = -(bin.rotation * face.normal);
    Ok(Grasp {
        side: face.side,
        at: Pose {
            position: (bin * spot).coords.into(),
            orientation_wxyz: pose::pointing(inward, rest_z(turn)),
        },
    })
}

/// The cup's z axis at rest: a grip near it turns the wrist least.
fn rest_z(turn: &Turn<'_>) -> Vector3<f64> {
    let z = geometry::rotation(turn.of.rest.orientation_wxyz) * Vector3::z();
    // Projected on the ground, because the cup will point down.
    Vector3::new(z.x, z.y, 0.0)
}

fn faces(turn: &Turn<'_>) -> [Face; 6] {
    let half = turn.of.size * 0.5;
    let face = |side, middle: [f64; 3], normal| Face {
        side,
        middle: Point3::from(middle),
        normal,
    };
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let floor = turn.of.wall_m - half.z;
    [
        face(Side::Floor, [0.0, 0.0, floor], z),
        face(Side::Bottom, [0.0, 0.0, -half.z], -z),
        face(Side::Wall, [half.x, 0.0, 0.0], x),
        face(Side::Wall, [-half.x, 0.0, 0.0], -x),
        face(Side::Wall, [0.0, half.y, 0.0], y),
        face(Side::Wall, [0.0, -half.y, 0.0], -y),
    ]
}

/// The spot of the floor nearest to its centre that no part covers. Everything in the way of
/// the tube counts.
fn free_spot(turn: &Turn<'_>, bin: &Isometry3<f64>, floor: &Face) -> Option<Point3<f64>> {
    let half = turn.of.size * 0.5;
    let room = turn.own.room_m;
    let wall = turn.of.wall_m + room;
    let inside =
        |p: &Vector3<f64>| p.x.abs() < half.x && p.y.abs() < half.y && p.z.abs() < 2.0 * half.z;
    // Parts up to a bin's height above the rim count: the tube of the cup passes there.
    let in_bin = |(centre, radius): (Vector3<f64>, f64)| {
        let local = bin.inverse_transform_point(&Point3::from(centre));
        inside(&local.coords).then_some((local, radius))
    };
    let (span_x, span_y) = (half.x - wall, half.y - wall);
    let spots = turn.own.spots.iter().flat_map(|x| {
        let row = turn.own.spots.iter();
        row.map(move |y| Vector3::new(x * span_x, y * span_y, 0.0))
    });
    let free = spots.filter(|spot| {
        let at = floor.middle + spot;
        let mut parts = parts(turn).filter_map(in_bin);
        parts.all(|(part, radius)| (part - at).xy().norm() > radius + room)
    });
    let nearest = free.min_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    Some(floor.middle + nearest)
}

/// The parts in the cell: centre, world frame (m), and radius (m).
fn parts(turn: &Turn<'_>) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    let parts = turn.of.parts.iter();
    parts.filter_map(|(part, radius)| {
        let position = turn.world.position(*part)?;
        Some((position, *radius))
    })
}
