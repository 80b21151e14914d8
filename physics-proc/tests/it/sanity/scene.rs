//! Scenes of plain shapes, with or without an arm that is at rest beside them.

use cell_model::cells::cell::ConveyorTable;
use cell_model::{Cell, Data, FixtureSpec, ObjectSpec, Shape};
use ipc_types::{DECISION_TICKS, Decision, Wire, WorldState};
use nalgebra::{Isometry3, Unit, UnitQuaternion, Vector3};
use physics_proc::engine::shapes;
use physics_proc::world::{StepInput, World};

/// Friction of every shape in a scene, unless a test gives another one.
pub(super) const FRICTION: f64 = 0.6;
const GRAVITY: f64 = 9.81;

/// A cell with a floor, to be filled.
pub(super) struct Scene {
    cell: Cell,
    object: ObjectSpec,
    fixture: FixtureSpec,
}

/// A scene as time passes.
pub(super) struct Running {
    pub(super) cell: Cell,
    pub(super) world: World,
    state: Box<WorldState>,
    decision: Decision,
}

impl Scene {
    /// An arm, where there is one, is at rest at (-1, -1) m.
    pub(super) fn new(arm: bool) -> Self {
        let mut cell = Cell::load(&Data::checkout(), "cube", 1, None).unwrap();
        let object = cell.objects.remove(0);
        let fixture = cell.fixtures.remove(0);
        cell.arms[0].base = Isometry3::translation(-1.0, -1.0, 0.0);
        if !arm {
            cell.arms.clear();
        }
        let mut scene = Self {
            cell,
            object,
            fixture,
        };
        let floor = Isometry3::translation(0.0, 0.0, -0.05);
        scene.fixture("floor", box_of([8.0, 8.0, 0.1]), floor, FRICTION);
        scene
    }

    /// Adds something fixed.
    pub(super) fn fixture(
        &mut self,
        name: &str,
        shape: Shape,
        pose: Isometry3<f64>,
        friction: f64,
    ) {
        self.cell.fixtures.push(FixtureSpec {
            name: name.to_owned(),
            shape,
            pose,
            friction,
            ..self.fixture.clone()
        });
    }

    /// Adds an object that never sleeps and has no damping; its index.
    pub(super) fn object(&mut self, shape: Shape, mass: f64, pose: Isometry3<f64>) -> usize {
        self.rough_object(shape, mass, FRICTION, pose)
    }

    /// As [`Scene::object`], with another friction.
    pub(super) fn rough_object(
        &mut self,
        shape: Shape,
        mass: f64,
        friction: f64,
        pose: Isometry3<f64>,
    ) -> usize {
        let index = self.cell.objects.len();
        self.cell.objects.push(ObjectSpec {
            name: format!("object {index}"),
            shape,
            mass,
            friction,
            pose,
            nominal: pose,
            sleeps: false,
            angular_damping: 0.0,
            parked: false,
            ..self.object.clone()
        });
        index
    }

    /// `count` objects far from (0, 0): boxes, cylinders, capsules and balls, a millimetre
    /// above the floor.
    pub(super) fn others(&mut self, count: usize) {
        for index in 0..count {
            let (column, row) = ((index % 14) as f64, (index / 14) as f64);
            let (shape, height) = any_shape(index);
            let (x, y) = (2.0 + 0.12 * column, 1.5 + 0.12 * row);
            self.object(shape, 0.1, Isometry3::translation(x, y, height + 1.0e-3));
        }
    }

    /// The fixture `name` becomes a belt that runs from the first tick.
    pub(super) fn belt(&mut self, name: &str, velocity: [f64; 3]) {
        self.cell.conveyor = Some(ConveyorTable {
            fixture: name.to_owned(),
            velocity_m_s: velocity,
            supply: None,
        });
    }

    pub(super) fn start(self) -> Running {
        let world = World::new(&self.cell).unwrap();
        let mut decision = Decision::zeroed();
        decision.io.conveyor_running = 1;
        let mut running = Running {
            cell: self.cell,
            world,
            state: Box::new(WorldState::zeroed()),
            decision,
        };
        running.look();
        running
    }
}

impl Running {
    pub(super) fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds * 1.0e3).round() as u64 {
            self.tick();
        }
        self.look();
    }

    /// Starts or stops the belt.
    pub(super) fn run_belt(&mut self, runs: bool) {
        self.decision.io.conveyor_running = runs.into();
    }

    /// Reads the present state.
    pub(super) fn look(&mut self) {
        self.world.write_state(&mut self.state);
    }

    pub(super) fn state(&self) -> &WorldState {
        &self.state
    }

    fn tick(&mut self) {
        let tick = self.world.tick();
        self.decision.header.tick = tick - tick % DECISION_TICKS;
        self.world.step(&StepInput {
            decision: Some(&self.decision),
            ..StepInput::default()
        });
    }

    pub(super) fn pose(&self, object: usize) -> Isometry3<f64> {
        crate::support::isometry(&self.state.objects[object].pose)
    }

    pub(super) fn place(&self, object: usize) -> Vector3<f64> {
        self.pose(object).translation.vector
    }

    pub(super) fn velocity(&self, object: usize) -> Vector3<f64> {
        self.state.objects[object].twist.linear.into()
    }

    pub(super) fn spin(&self, object: usize) -> Vector3<f64> {
        self.state.objects[object].twist.angular.into()
    }

    /// Kinetic and potential energy of all objects (J).
    pub(super) fn energy(&self) -> f64 {
        let objects = self.cell.objects.iter().enumerate();
        objects
            .map(|(index, spec)| self.energy_of(index, spec))
            .sum()
    }

    fn energy_of(&self, index: usize, spec: &ObjectSpec) -> f64 {
        let (shape, own) = shapes::shared(&spec.shape);
        let unit = shape.mass_properties(1.0);
        let scale = spec.mass / unit.mass();
        let inertia = unit.principal_inertia();
        let frame = unit.principal_inertia_local_frame;
        let turn = nalgebra::Quaternion::new(frame.w, frame.x, frame.y, frame.z);
        let axes = self.pose(index).rotation * own.rotation * UnitQuaternion::new_normalize(turn);
        let spin = axes.inverse() * self.spin(index);
        let turning: f64 = (0..3).map(|k| scale * inertia[k] * spin[k] * spin[k]).sum();
        let moving = spec.mass * self.velocity(index).norm_squared();
        0.5 * (turning + moving) + spec.mass * GRAVITY * self.place(index).z
    }
}

/// A turn about y so that an upright shape has its axis along x.
pub(super) fn lying() -> UnitQuaternion<f64> {
    about(Vector3::y_axis(), 90.0)
}

pub(super) fn about(axis: Unit<Vector3<f64>>, degrees: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&axis, degrees.to_radians())
}

pub(super) fn box_of(size_m: [f64; 3]) -> Shape {
    Shape::Box { size_m }
}

pub(super) fn cube() -> Shape {
    box_of([0.05; 3])
}

/// One of the plain shapes, upright, and half its height (m).
fn any_shape(index: usize) -> (Shape, f64) {
    match index % 4 {
        0 => (cube(), 0.025),
        1 => (cylinder(), 0.03),
        2 => (ball(), 0.02),
        _ => (box_of([0.06, 0.04, 0.02]), 0.01),
    }
}

pub(super) fn cylinder() -> Shape {
    Shape::Cylinder {
        radius_m: 0.02,
        height_m: 0.06,
    }
}

pub(super) fn ball() -> Shape {
    Shape::Sphere { radius_m: 0.02 }
}

pub(super) fn capsule() -> Shape {
    Shape::Capsule {
        radius_m: 0.02,
        height_m: 0.06,
    }
}

/// Every shape an object can have, at rest on a level plane at the origin; those that roll
/// have their axis along x.
pub(super) fn every_shape() -> Vec<(&'static str, Shape, Isometry3<f64>)> {
    let bin = Shape::Bin {
        size_m: [0.3, 0.2, 0.147],
        wall_m: 0.004,
    };
    let over = |height: f64| Isometry3::translation(0.0, 0.0, height);
    let flipped = about(Vector3::x_axis(), 180.0);
    vec![
        ("box", cube(), over(0.025)),
        ("plate", box_of([0.1, 0.1, 0.004]), over(0.002)),
        ("bin", bin.clone(), over(0.0735)),
        ("bin upside down", bin, over(0.0735) * flipped),
        ("cylinder upright", cylinder(), over(0.03)),
        ("cylinder lying", cylinder(), over(0.02) * lying()),
        ("capsule lying", capsule(), over(0.02) * lying()),
        ("ball", ball(), over(0.02)),
    ]
}
