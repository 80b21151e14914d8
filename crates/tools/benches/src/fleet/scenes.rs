//! Cells of any size: `reach`, a resting arm, with more of one thing.

use cell_model::cells::cell::SpawnArea;
use cell_model::random::Random;
use cell_model::{ArmSpec, Cell, Data, FixtureSpec, ModelError, ObjectSpec, Shape};
use cell_sim::eval::template;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// The cell on which all are based.
pub(crate) const DEMO: &str = "reach";
/// Outer edge lengths of a bin, and its walls (m).
const BIN_M: [f64; 3] = [0.3, 0.2, 0.147];
const WALL_M: f64 = 0.004;
/// Bins of a column, and columns of a row.
const LEVELS: usize = 4;
const COLUMNS: usize = 3;
/// Edge of a cube, and the distance from one to the next (m).
const CUBE_M: f64 = 0.05;
const PITCH_M: f64 = 0.1;
const CUBES_IN_A_ROW: usize = 30;
/// Height of the shoulder of the arm (m).
const SHOULDER_M: f64 = 0.33;
/// Distance at which objects are placed, out of reach of the arm (m).
const OUT_OF_REACH_M: f64 = 1.1;

/// Cubes in reach of the arm, on a shell around its shoulder.
pub(super) fn obstacles(count: usize) -> Result<Cell, ModelError> {
    let mut cell = base()?;
    // A fixed seed: each size has the obstacles of the smaller ones and some more.
    let mut random = Random::new(42);
    for index in 0..count {
        let angle = random.around_zero(std::f64::consts::PI);
        let rise = 0.4 + random.around_zero(0.7);
        let radius = 0.8 + random.around_zero(0.05);
        let place = Translation3::new(
            radius * rise.cos() * angle.cos(),
            radius * rise.cos() * angle.sin(),
            SHOULDER_M + radius * rise.sin(),
        );
        cell.fixtures.push(FixtureSpec {
            name: format!("obstacle_{index}"),
            shape: cube(),
            pose: place.into(),
            friction: 0.6,
            solid: true,
            obstacle: true,
            colour: [0.5; 3],
        });
    }
    Ok(cell)
}

/// Cubes apart from each other on the floor.
pub(crate) fn cubes(count: usize) -> Result<Cell, ModelError> {
    let mut cell = base()?;
    let place = |index: usize| {
        let (row, column) = (index / CUBES_IN_A_ROW, index % CUBES_IN_A_ROW);
        Isometry3::translation(
            OUT_OF_REACH_M + PITCH_M * row as f64,
            PITCH_M * column as f64 - 1.5,
            0.5 * CUBE_M,
        )
    };
    let cubes = (0..count).map(|index| object(index, cube(), place(index)));
    cell.objects.extend(cubes);
    Ok(cell)
}

/// Parts that fall into one fixed bin.
pub(crate) fn pile(count: usize) -> Result<Cell, ModelError> {
    let mut cell = base()?;
    cell.fixtures.push(FixtureSpec {
        name: "bin".to_owned(),
        shape: bin(),
        pose: Isometry3::translation(OUT_OF_REACH_M, 0.0, 0.5 * BIN_M[2]),
        friction: 0.6,
        solid: true,
        obstacle: false,
        colour: [0.5; 3],
    });
    let mut random = Random::new(7);
    for index in 0..count {
        let place = Translation3::new(
            OUT_OF_REACH_M + 0.1 * (index % 2) as f64 - 0.05 + random.around_zero(0.03),
            0.08 * (index / 2 % 2) as f64 - 0.04 + random.around_zero(0.015),
            0.2 + 0.035 * (index / 4) as f64,
        );
        let [roll, pitch, yaw] = std::array::from_fn(|_| random.around_zero(1.5));
        let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        let shape = Shape::Box {
            size_m: [0.024, 0.02, 0.016],
        };
        let mut part = object(index, shape, Isometry3::from_parts(place, turn));
        part.mass = 0.03;
        part.angular_damping = 2.0;
        cell.objects.push(part);
    }
    Ok(cell)
}

/// Bins that sleep when at rest, in columns of four.
pub(crate) fn bins_asleep(count: usize) -> Result<Cell, ModelError> {
    let mut cell = base()?;
    for index in 0..count {
        let (column, level) = (index / LEVELS, index % LEVELS);
        let place = Isometry3::translation(
            OUT_OF_REACH_M + 0.31 * (column % COLUMNS) as f64,
            0.21 * (column / COLUMNS) as f64,
            0.5 * BIN_M[2] + 0.001 + 0.148 * level as f64,
        );
        let mut bin = object(index, bin(), place);
        bin.mass = 0.6;
        bin.sleeps = true;
        cell.objects.push(bin);
    }
    cell.bins = count;
    Ok(cell)
}

/// Arms side by side, each of which keeps away from the others.
pub(super) fn arms(count: usize) -> Result<Cell, ModelError> {
    let mut cell = base()?;
    let Some(arm) = cell.arms.pop() else {
        return Ok(cell);
    };
    cell.arms.extend((0..count).map(|index| ArmSpec {
        name: format!("arm_{index}"),
        base: Isometry3::translation(0.0, 0.8 * index as f64, 0.0),
        ..arm.clone()
    }));
    Ok(cell)
}

/// A resting arm on a floor.
fn base() -> Result<Cell, ModelError> {
    template(DEMO, "").load_cell_from(&Data::checkout())
}

fn cube() -> Shape {
    Shape::Box {
        size_m: [CUBE_M; 3],
    }
}

fn bin() -> Shape {
    Shape::Bin {
        size_m: BIN_M,
        wall_m: WALL_M,
    }
}

fn object(index: usize, shape: Shape, pose: Isometry3<f64>) -> ObjectSpec {
    ObjectSpec {
        name: format!("object_{index}"),
        shape,
        mass: 0.1,
        friction: 0.6,
        pose,
        nominal: pose,
        spawn: SpawnArea::default(),
        kind: "object".to_owned(),
        parked: false,
        obstacle: false,
        sleeps: false,
        angular_damping: 0.0,
        colour: [0.5; 3],
    }
}
