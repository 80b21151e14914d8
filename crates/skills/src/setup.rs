//! A cell as skills need it, resolved once from its files.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

use cell_model::{ArmSpec, Cell, ObjectSpec, Robot, Shape, suggest};
use ipc_types::{MAX_JOINTS, Pose};
use nalgebra::{Vector2, Vector3};
use robocell_task::SetupError;
use robocell_task::job::Placement;

use crate::ability::{self, Need};
use crate::geometry;
use crate::settings::PlaceTable;

/// Share of the length of the stretched arm that it reaches with the tool straight down.
const REACH_SHARE: f64 = 0.9;
/// Fingers within this of the open width are open (m).
const OPEN_TOLERANCE_M: f64 = 0.008;

/// Index of the arm of a job with one arm.
pub const ARM: usize = 0;

/// The tool of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tool {
    /// Two fingers; the TCP's z axis points out of the hand.
    Fingers {
        /// Width of the open hand (m).
        open_width_m: f64,
        /// Fingers within this of the open width are open (m).
        open_tolerance_m: f64,
        /// Force per finger (N).
        force_n: f64,
    },
    /// A suction cup; the TCP's x axis points out of it.
    Suction,
    /// No gripper; the TCP's z axis counts as its direction.
    None,
}

/// An arm of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmSetup {
    /// Its name in the cell file.
    pub name: String,
    /// Its base, world frame (m).
    pub base: Vector3<f64>,
    /// Its joint positions at the start (rad or m).
    pub home: [f64; MAX_JOINTS],
    /// Its gripper.
    pub tool: Tool,
    /// An object farther from the base in the plane is out of reach (m).
    pub reach_m: f64,
    /// Pose of the TCP while the arm waits for a zone in which another arm works: the pose at
    /// the start, unless the job sets another. World frame.
    pub wait: Pose,
}

/// A movable object of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSetup {
    /// Its name in the cell file.
    pub name: String,
    /// Half of its height when it is upright (m).
    pub half_height_m: f64,
    /// Its narrowest side (m).
    pub narrowest_m: f64,
    /// Bit of [`ipc_types::ArmGoal::object_mask`], for one that is an obstacle.
    pub obstacle_bit: Option<u32>,
}

/// A named place: one slot, or a pattern of them in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceSetup {
    /// Its name in the cell file.
    pub name: String,
    /// By slot: the point of the surface below the object's centre (m), and the
    /// object's turn (rad). World frame.
    pub slots: Vec<Placement>,
}

/// A cell as skills see it.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// By arm of the cell.
    pub arms: Vec<ArmSetup>,
    /// By object of the cell.
    pub objects: Vec<ObjectSetup>,
    /// The places of `[task]`.
    pub places: Vec<PlaceSetup>,
    /// Names of the cell's sensors, in their order.
    pub sensors: Vec<String>,
    /// Names of the cell's obstacles; the index is the bit in a mask.
    pub obstacles: Vec<String>,
    /// Obstacles that exist in physics; the others only guide a motion.
    pub solid_obstacles: u64,
    /// Picks that files name.
    pub(crate) picks: Picks,
}

/// Arm and object of each pick that a file names, collected while its nodes are created: later
/// only the nodes have them. Not compared.
#[derive(Clone, Debug, Default)]
pub(crate) struct Picks(Arc<Mutex<BTreeSet<(usize, usize)>>>);

impl PartialEq for Picks {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl Picks {
    /// Records that `arm` picks `object`.
    pub(crate) fn note(&self, arm: usize, object: usize) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert((arm, object));
    }

    /// All recorded picks.
    pub(crate) fn all(&self) -> BTreeSet<(usize, usize)> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.clone()
    }
}

impl Setup {
    /// The setup of `cell`, with the places of its task.
    pub fn new<'p>(
        cell: &Cell,
        places: impl IntoIterator<Item = (&'p String, &'p PlaceTable)>,
    ) -> Self {
        let mut objects: Vec<ObjectSetup> = cell.objects.iter().map(ObjectSetup::of).collect();
        for (bit, (index, _)) in (0_u32..64).zip(cell.obstacle_objects()) {
            if let Some(object) = objects.get_mut(index) {
                object.obstacle_bit = Some(bit);
            }
        }
        let guides = cell.obstacles().enumerate().filter(|(_, o)| !o.solid);
        Self {
            arms: cell.arms.iter().map(ArmSetup::of).collect(),
            objects,
            places: places.into_iter().map(|(n, p)| place(n, p)).collect(),
            sensors: cell.sensors.iter().map(|s| s.name.clone()).collect(),
            obstacles: cell.obstacles().map(|o| o.name.clone()).collect(),
            solid_obstacles: guides.fold(u64::MAX, |mask, (bit, _)| mask & !(1 << bit.min(63))),
            picks: Picks::default(),
        }
    }

    /// Adds a place that `[task]` does not have.
    pub fn add_place(&mut self, name: &str, table: &PlaceTable) {
        self.places.push(place(name, table));
    }

    /// The setup without a cell: every name counts as known when a file is checked alone.
    pub(crate) fn unknown() -> Self {
        Self {
            arms: Vec::new(),
            objects: Vec::new(),
            places: Vec::new(),
            sensors: Vec::new(),
            obstacles: Vec::new(),
            solid_obstacles: u64::MAX,
            picks: Picks::default(),
        }
    }

    /// Index of an object by name.
    pub fn object(&self, name: &str) -> Option<usize> {
        self.objects.iter().position(|object| object.name == name)
    }

    /// Index of a place by name.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.places.iter().position(|place| place.name == name)
    }

    /// Index of an arm by name.
    pub fn arm(&self, name: &str) -> Option<usize> {
        self.arms.iter().position(|arm| arm.name == name)
    }

    /// Index of a sensor by name.
    pub fn sensor(&self, name: &str) -> Option<usize> {
        self.sensors.iter().position(|sensor| sensor == name)
    }

    /// As [`Setup::object`], for a policy that needs it.
    ///
    /// # Errors
    /// Returns a [`SetupError`] with the nearest name.
    pub fn need_object(&self, cell: &Cell, name: &str) -> Result<usize, SetupError> {
        let known: Vec<&str> = self.objects.iter().map(|o| o.name.as_str()).collect();
        need(cell, "object", name, self.object(name), &known)
    }

    /// As [`Setup::place`], for a policy that needs it.
    ///
    /// # Errors
    /// Returns a [`SetupError`] with the nearest name.
    pub fn need_place(&self, cell: &Cell, name: &str) -> Result<usize, SetupError> {
        let known: Vec<&str> = self.places.iter().map(|p| p.name.as_str()).collect();
        need(cell, "place", name, self.place(name), &known)
    }

    /// Refuses a job whose `arm` cannot pick up `object`, for a policy that does nothing else
    /// (ADR 0026).
    ///
    /// # Errors
    /// Returns a [`SetupError`] with the lack of the arm.
    pub fn need_grip(&self, cell: &Cell, arm: usize, object: usize) -> Result<(), SetupError> {
        let object = self.objects.get(object);
        let lack = self.arms.get(arm).and_then(|arm| {
            let lack = ability::lacks(arm, Need::Grip(object))?;
            let object = object.map(|object| object.name.as_str());
            Some(ability::refusal(&arm.name, object, lack))
        });
        lack.map_or(Ok(()), |why| Err(SetupError::new(cell, why)))
    }

    /// Name of an object, for logs.
    pub fn object_name(&self, object: usize) -> &str {
        self.objects.get(object).map_or("?", |o| o.name.as_str())
    }

    /// The pose of an object's centre in a slot; `None` for a slot or an object that does not
    /// exist.
    pub fn goal(&self, object: usize, place: usize, slot: usize) -> Option<Placement> {
        let slot = self.places.get(place)?.slots.get(slot)?;
        let [x, y, z] = slot.position;
        let position = [x, y, z + self.objects.get(object)?.half_height_m];
        Some(Placement { position, ..*slot })
    }
}

impl ArmSetup {
    /// Whether the arm reaches a point with the tool straight down (m).
    pub fn reaches(&self, point: Vector3<f64>) -> bool {
        let off = point - self.base;
        off.xy().norm() <= self.reach_m && off.z.abs() <= self.reach_m
    }
}

impl Tool {
    /// The tool of a robot.
    pub fn of(robot: &Robot) -> Self {
        match (&robot.gripper, &robot.suction) {
            (Some(gripper), _) => Self::Fingers {
                open_width_m: gripper.max_width,
                open_tolerance_m: OPEN_TOLERANCE_M,
                force_n: gripper.default_force,
            },
            (None, Some(_)) => Self::Suction,
            (None, None) => Self::None,
        }
    }

    /// Orientation of the TCP with the tool straight down, turned by `yaw`
    /// about the vertical axis (rad); w x y z.
    pub fn down(self, yaw: f64) -> [f64; 4] {
        match self {
            Self::Suction => geometry::straight_down_by_x(yaw),
            Self::Fingers { .. } | Self::None => geometry::straight_down(yaw),
        }
    }

    /// The inverse of [`Tool::down`] (rad).
    pub fn yaw(self, orientation_wxyz: [f64; 4]) -> f64 {
        let rotation = geometry::rotation(orientation_wxyz);
        let axis = match self {
            Self::Suction => rotation * Vector3::z(),
            Self::Fingers { .. } | Self::None => rotation * Vector3::x(),
        };
        libm::atan2(axis.y, axis.x)
    }

    /// Height of the TCP above the centre of an object that is gripped from
    /// above (m).
    pub fn grasp_height(self, object: &ObjectSetup) -> f64 {
        match self {
            Self::Suction => object.half_height_m,
            Self::Fingers { .. } | Self::None => 0.0,
        }
    }
}

/// The cell's first arm, which has a suction gripper.
///
/// # Errors
/// Returns a [`SetupError`] for a cell without one.
pub fn suction_arm(cell: &Cell) -> Result<&ArmSpec, SetupError> {
    let arm = cell.arms.get(ARM);
    let arm =
        arm.ok_or_else(|| SetupError::new(cell, "there is no [[arm]]; this job needs one"))?;
    if arm.robot.suction.is_none() {
        let name = &arm.robot.name;
        let problem = format!("robot '{name}' has no suction gripper; this job needs one");
        return Err(SetupError::new(cell, problem));
    }
    Ok(arm)
}

/// Bits of [`ipc_types::ArmGoal::obstacle_mask`] of the obstacles whose name `named` accepts.
pub fn obstacle_bits(cell: &Cell, named: impl Fn(&str) -> bool) -> u64 {
    let obstacles = cell.obstacles().take(64).enumerate();
    obstacles
        .filter(|(_, obstacle)| named(&obstacle.name))
        .fold(0, |mask, (bit, _)| mask | 1 << bit)
}

fn need(
    cell: &Cell,
    what: &str,
    name: &str,
    found: Option<usize>,
    known: &[&str],
) -> Result<usize, SetupError> {
    found.ok_or_else(|| {
        let advice = suggest::advice(name, known);
        SetupError::new(cell, format!("there is no {what} '{name}'; {advice}"))
    })
}

impl ArmSetup {
    /// Whether a joint is more than half a turn from its position at the start: the elbow or
    /// the wrist is in another branch, or wound up.
    pub fn is_wound(&self, joint_positions: &[f64; MAX_JOINTS]) -> bool {
        let off = self.home.iter().zip(joint_positions).map(|(a, b)| a - b);
        off.into_iter().any(|off| off.abs() > std::f64::consts::PI)
    }

    /// The setup of `spec`.
    pub fn of(spec: &ArmSpec) -> Self {
        let mut home = [0.0; MAX_JOINTS];
        for (slot, position) in home.iter_mut().zip(&spec.home) {
            *slot = *position;
        }
        let all = spec.robot.with_arm_positions(&spec.home);
        let tcp = spec.robot.frame_pose(spec.robot.tcp_frame, &all);
        let tcp = spec.base * tcp.unwrap_or_default();
        let orientation = tcp.rotation.quaternion();
        Self {
            wait: Pose {
                position: tcp.translation.vector.into(),
                orientation_wxyz: [orientation.w, orientation.i, orientation.j, orientation.k],
            },
            name: spec.name.clone(),
            base: spec.base.translation.vector,
            home,
            tool: Tool::of(&spec.robot),
            reach_m: reach(&spec.robot),
        }
    }
}

/// The links between the second joint and the last, stretched; the tool points down and adds
/// nothing.
fn reach(robot: &Robot) -> f64 {
    let joints = robot.chain.joints();
    let controlled = robot.arm_joints.iter().filter_map(|i| joints.get(*i));
    let stretched: f64 = controlled
        .skip(2)
        .map(|joint| joint.origin.translation.vector.norm())
        .sum();
    REACH_SHARE * stretched
}

impl ObjectSetup {
    /// The setup of `spec`.
    pub fn of(spec: &ObjectSpec) -> Self {
        let half_height_m = match spec.shape {
            Shape::Box { size_m } | Shape::Bin { size_m, .. } => 0.5 * size_m[2],
            Shape::Sphere { radius_m } => radius_m,
            Shape::Cylinder { height_m, .. } => 0.5 * height_m,
            Shape::Capsule { radius_m, height_m } => radius_m + 0.5 * height_m,
        };
        Self {
            name: spec.name.clone(),
            half_height_m,
            narrowest_m: narrowest(&spec.shape),
            obstacle_bit: None,
        }
    }
}

/// The narrowest side of a shape (m).
fn narrowest(shape: &Shape) -> f64 {
    match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => {
            size_m.into_iter().fold(f64::INFINITY, f64::min)
        }
        Shape::Sphere { radius_m } | Shape::Capsule { radius_m, .. } => 2.0 * radius_m,
        Shape::Cylinder { radius_m, height_m } => height_m.min(2.0 * radius_m),
    }
}

pub(crate) fn place(name: &str, table: &PlaceTable) -> PlaceSetup {
    let along = |offset: [f64; 3]| {
        let plane = geometry::turned(Vector2::new(offset[0], offset[1]), table.yaw_rad);
        let [x, y, z] = table.position_m;
        Placement {
            position: [x + plane.x, y + plane.y, z + offset[2]],
            yaw: table.yaw_rad,
        }
    };
    PlaceSetup {
        name: name.to_owned(),
        slots: table.offsets().into_iter().map(along).collect(),
    }
}
