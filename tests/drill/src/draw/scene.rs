//! Draws scenes: robots, objects in several arrangements, and what the task does.

use super::{Draw, behaviour};
use crate::scene::{Joint, Object, Scene, TUB_X_M, TaskPlan};

/// Shapes, by how often they are drawn.
const SHAPES: [&str; 10] = [
    "box", "box", "box", "box", "box", "cylinder", "sphere", "capsule", "bin", "cylinder",
];
/// Most bytes of memory of a stub task: more than any message or slot holds at once.
const MEMORY_BYTES: u64 = 200_000;

/// One or two arms with one joint each and next to nothing around: what costs time is not what
/// this level is for.
pub(super) fn small(draw: &mut Draw) -> Scene {
    let object = |index: u32| Object {
        name: format!("object_{index}"),
        shape: "box".to_owned(),
        size_m: 0.05,
        mass_kg: 0.1,
        friction: 0.8,
        position_m: [2.0, f64::from(index) * 0.2, 0.025],
    };
    let count = [0, 0, 0, 1, 2][draw.index(5)];
    Scene {
        ideal: true,
        arms: if draw.percent(85) { 1 } else { 2 },
        joints: vec![joint(draw, "revolute")],
        objects: (0..count).map(object).collect(),
        tub: false,
        task: TaskPlan::Stub {
            memory: if draw.percent(20) {
                memory(draw, 2_000)
            } else {
                0
            },
            poses: false,
            fails_at: fails_at(draw),
        },
    }
}

/// Generated arms that RMPflow moves, and nothing else.
pub(super) fn arms(draw: &mut Draw) -> Scene {
    Scene {
        ideal: true,
        arms: if draw.percent(70) { 1 } else { 2 },
        joints: robot(draw),
        objects: Vec::new(),
        tub: false,
        task: TaskPlan::Stub {
            memory: memory(draw, MEMORY_BYTES),
            poses: true,
            fails_at: fails_at(draw),
        },
    }
}

/// Up to 160 objects, an arm or two, and a task of some kind.
pub(super) fn whole(draw: &mut Draw) -> Scene {
    let is_franka = draw.percent(60);
    let objects = objects(draw);
    // A task that names what the hand cannot grip is refused.
    let fit = objects.iter().filter(|object| object.size_m <= GRIPPED_M);
    let names: Vec<&str> = fit.map(|object| object.name.as_str()).collect();
    let has_task = is_franka && draw.percent(60) && !names.is_empty();
    let task = if has_task {
        behaviour::any(draw, &names)
    } else {
        TaskPlan::Stub {
            memory: memory(draw, MEMORY_BYTES),
            poses: draw.percent(70),
            fails_at: fails_at(draw),
        }
    };
    Scene {
        ideal: false,
        arms: if has_task || draw.percent(80) { 1 } else { 2 },
        joints: if is_franka { Vec::new() } else { robot(draw) },
        tub: objects.iter().any(|object| object.position_m[2] > 1.0),
        objects,
        task,
    }
}

fn fails_at(draw: &mut Draw) -> u64 {
    if draw.percent(5) { draw.log(1, 500) } else { 0 }
}

fn memory(draw: &mut Draw, most: u64) -> u32 {
    u32::try_from(draw.log(1, most) - 1).unwrap_or(0)
}

/// Two to seven joints.
fn robot(draw: &mut Draw) -> Vec<Joint> {
    let count = 2 + draw.below(6);
    let kinds = [
        "revolute",
        "revolute",
        "revolute",
        "continuous",
        "prismatic",
    ];
    let one = |_| {
        let kind = kinds[draw.index(kinds.len())];
        joint(draw, kind)
    };
    (0..count).map(one).collect()
}

fn joint(draw: &mut Draw, kind: &str) -> Joint {
    Joint {
        kind: kind.to_owned(),
        axis: u8::try_from(draw.below(3)).unwrap_or(0),
        range: if kind == "prismatic" {
            0.001 * draw.log(10, 300) as f64
        } else {
            0.1 * draw.log(5, 30) as f64
        },
        length_m: 0.01 * draw.log(5, 40) as f64,
        mass_kg: 0.01 * draw.log(10, 1000) as f64,
    }
}

/// What a Franka hand grips (m).
const GRIPPED_M: f64 = 0.078;

/// Few objects mostly, and now and then as many as a cell may have.
fn objects(draw: &mut Draw) -> Vec<Object> {
    let count = match draw.below(100) {
        0..=44 => draw.log(1, 5),
        45..=74 => draw.log(5, 21),
        75..=89 => draw.log(21, 61),
        90..=95 => draw.log(61, 160),
        _ => 160,
    };
    let arrangement = draw.below(4);
    let size_m = 0.001 * draw.log(30, 120) as f64;
    let one = |index| object(draw, (arrangement, size_m), index);
    (0..count).map(one).collect()
}

fn object(draw: &mut Draw, (arrangement, size_m): (u64, f64), index: u64) -> Object {
    // Neighbours do not touch at the start.
    let pitch_m = 1.8 * size_m;
    let on_floor_m = 0.75 * size_m;
    let (across, up) = ((index % 12) as f64, (index / 12) as f64);
    let position_m = match arrangement {
        // Spread in front of the arm.
        0 => [0.3 + pitch_m * up, pitch_m * (across - 6.0), on_floor_m],
        // A grid on the far side.
        1 => [-0.8 - pitch_m * up, pitch_m * (across - 6.0), on_floor_m],
        // Columns of four.
        2 => {
            let column = (index / 4) as f64;
            let height_m = on_floor_m + 1.6 * size_m * (index % 4) as f64;
            [
                0.4 + 2.0 * pitch_m * (column / 6.0).floor(),
                2.0 * pitch_m * (column % 6.0 - 2.5),
                height_m,
            ]
        }
        // A heap: layers of nine fall into the tub.
        _ => {
            let (x, y) = ((index % 3) as f64 - 1.0, (index / 3 % 3) as f64 - 1.0);
            [
                TUB_X_M + pitch_m * x,
                pitch_m * y,
                1.1 + pitch_m * (index / 9) as f64,
            ]
        }
    };
    let name = match draw.below(20) {
        0 => format!("o{index}"),
        1 => format!("object_{index}_with_a_long_name"),
        _ => format!("object_{index}"),
    };
    Object {
        name,
        shape: SHAPES[draw.index(SHAPES.len())].to_owned(),
        size_m,
        mass_kg: 0.001 * draw.log(10, 2_000) as f64,
        friction: 0.1 * draw.log(2, 12) as f64,
        position_m,
    }
}
