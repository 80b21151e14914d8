//! Costs of heaps: 36 bins in columns, awake and asleep, and 100 parts that fall into one; and
//! the same in `MuJoCo`, step by step in the same run, where it is installed.

use crate::report::{Report, Samples};
use cell_model::random::Random;
use cell_model::{Cell, Data, Shape};
use cell_rt::monotonic_ns;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use physics_proc::world::{StepInput, World};

use crate::error::CoreError;
use crate::mujoco::{self, Settings};

/// Bins: three by three columns of four.
const BINS: usize = 36;
/// Parts that fall.
const PARTS: usize = 100;
/// Ticks measured, and ticks in which bins may fall asleep first.
const TICKS: usize = 4_000;
/// Ticks of one engine before the turn of the other: a slow minute of the machine affects both.
const CHUNK: usize = 100;

const CELL: &str = r#"
description = "Heaps"
policies = ["none"]
default_policy = "none"
time_limit_s = 100.0
camera = { eye_m = [2.0, 2.0, 2.0], target_m = [0.0, 0.0, 0.0] }
task = { kind = "reach" }

[[arm]]
name = "ur10"
robot = "ur10"
base_position_m = [0.0, 0.0, 0.0]

[[object]]
name = "bin"
count = 36
shape = { kind = "bin", size_m = [0.3, 0.2, 0.147], wall_m = 0.004 }
mass_kg = 0.6
friction = 0.6
position_m = [0.0, 0.0, 0.0]
colour = [0.5, 0.5, 0.5]

[[object]]
name = "part"
count = 100
shape = { kind = "box", size_m = [0.024, 0.02, 0.016] }
mass_kg = 0.03
friction = 0.6
angular_damping = 2.0
position_m = [0.0, 0.0, 0.0]
colour = [0.5, 0.5, 0.5]

[[fixture]]
name = "floor"
shape = { kind = "box", size_m = [4.0, 4.0, 0.1] }
position_m = [0.0, 0.0, -0.05]
friction = 0.6
obstacle = false
colour = [0.5, 0.5, 0.5]
"#;

/// Adds the rows of all heaps.
pub(crate) fn run(report: &mut Report) -> Result<(), CoreError> {
    compare(report, "36 bins", &bins(false)?)?;
    let mut asleep = World::new(&bins(true)?)?;
    // Settled first: falling asleep is not part of the cost of sleeping.
    for _ in 0..TICKS {
        asleep.step(&StepInput::default());
    }
    let mut samples = Samples::with_capacity(TICKS);
    step(&mut asleep, TICKS, &mut samples);
    report
        .rows
        .push(samples.into_row("36 bins, asleep".to_owned()));
    compare(report, "100 parts", &parts()?)
}

fn compare(report: &mut Report, name: &str, cell: &Cell) -> Result<(), CoreError> {
    let mut world = World::new(cell)?;
    let mut other = mujoco::start(cell, Settings::default());
    let (mut ours, mut theirs) = (Samples::with_capacity(TICKS), Samples::default());
    for _ in 0..TICKS / CHUNK {
        // After half a second at rest they would fall asleep.
        world.wake_objects();
        step(&mut world, CHUNK, &mut ours);
        if let Some(mujoco) = &mut other {
            theirs.record_all(&mujoco.step(CHUNK, &[]));
        }
    }
    let row = ours.into_row(name.to_owned());
    report.notes.push(format!(
        "{name}: real-time factor {:.1}, deepest contact {:.2} mm",
        1000.0 / row.p50.max(1.0e-3),
        world.penetration() * 1.0e3
    ));
    report.rows.push(row);
    let Some(mujoco) = other else {
        report.note_once(mujoco::MISSING);
        return Ok(());
    };
    let against = format!("{name}, MuJoCo {}", mujoco.version());
    report.rows.push(theirs.into_row(against.clone()));
    report.note_once("bins and parts: MuJoCo with its own settings (cone pyramidal, sparse), 1 ms");
    report.compare(name, &against);
    Ok(())
}

fn step(world: &mut World, ticks: usize, samples: &mut Samples) {
    for _ in 0..ticks {
        let began_ns = monotonic_ns();
        world.step(&StepInput::default());
        samples.record(monotonic_ns().saturating_sub(began_ns));
    }
}

/// The floor, and the objects whose table has this name.
fn cell(kind: &str) -> Result<Cell, CoreError> {
    let mut cell = Cell::from_text(&Data::checkout(), "heaps", "bench", CELL, 0, None)?;
    cell.arms.clear();
    cell.objects.retain(|object| object.kind == kind);
    Ok(cell)
}

fn bins(sleeps: bool) -> Result<Cell, CoreError> {
    let mut cell = cell("bin")?;
    for (index, bin) in cell.objects.iter_mut().enumerate().take(BINS) {
        let (column, layer) = (index % 9, index / 9);
        bin.sleeps = sleeps;
        bin.pose = Isometry3::translation(
            0.31 * (column % 3) as f64,
            0.21 * (column / 3) as f64,
            0.0735 + 0.001 + 0.148 * layer as f64,
        );
    }
    Ok(cell)
}

/// Boxes, capsules and cylinders above a fixed bin.
fn parts() -> Result<Cell, CoreError> {
    let mut cell = cell("part")?;
    let mut bin = cell.fixtures.clone();
    for fixture in &mut bin {
        "bin".clone_into(&mut fixture.name);
        fixture.shape = Shape::Bin {
            size_m: [0.3, 0.2, 0.147],
            wall_m: 0.004,
        };
        fixture.pose = Isometry3::translation(0.0, 0.0, 0.0735);
    }
    cell.fixtures.extend(bin);
    let shapes = [
        Shape::Box {
            size_m: [0.024, 0.02, 0.016],
        },
        Shape::Capsule {
            radius_m: 0.007,
            height_m: 0.02,
        },
        Shape::Cylinder {
            radius_m: 0.01,
            height_m: 0.016,
        },
    ];
    // A fixed seed: every run drops the same parts.
    let mut random = Random::new(7);
    let objects = cell.objects.iter_mut().enumerate().take(PARTS);
    for ((index, part), shape) in objects.zip(shapes.iter().cycle()) {
        let [w, x, y, z] = std::array::from_fn(|_| random.around_zero(0.5));
        let place = Translation3::new(
            0.1 * (index % 2) as f64 - 0.05 + random.around_zero(0.03),
            0.08 * (index / 2 % 2) as f64 - 0.04 + random.around_zero(0.015),
            0.2 + 0.035 * (index / 4) as f64,
        );
        part.shape = shape.clone();
        part.sleeps = false;
        part.pose = Isometry3::from_parts(
            place,
            UnitQuaternion::new_normalize(Quaternion::new(w + 1.0, x, y, z)),
        );
    }
    Ok(cell)
}
