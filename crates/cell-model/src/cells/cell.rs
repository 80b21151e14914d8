//! A cell ready to run: robots loaded, objects placed by the seed.

use std::borrow::Cow;

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::cells::check_file;
use crate::cells::file::{CellFile, ObjectTable, numbered};
use crate::cells::replace::Replace;
use crate::cells::setting::{self, Setting};
use crate::cells::task_table::TaskTable;
use crate::check::Checker;
use crate::data::Data;
use crate::error::ModelError;
use crate::random::Random;
use crate::robots::files::RobotFiles;
use crate::robots::robot::Robot;
use crate::runs::policy_name::policy_of_kind;
use crate::shape::Shape;
use crate::{suggest, toml_text};

pub use crate::cells::file::{
    Camera, ConveyorTable, DispenserTable, Disturbance, SensorTable, SpawnArea, SupplyTable,
};

/// A cell.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Name of the demo.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// Policies that can run it.
    pub policies: Vec<String>,
    /// Policy of a run that names none.
    pub default_policy: String,
    /// Simulated time after which the run has failed (s).
    pub time_limit_s: f64,
    /// Arms in the order of commands and states.
    pub arms: Vec<ArmSpec>,
    /// Movable objects in the order of [`ipc_types::WorldState::objects`].
    pub objects: Vec<ObjectSpec>,
    /// Fixtures.
    pub fixtures: Vec<FixtureSpec>,
    /// The belt.
    pub conveyor: Option<ConveyorTable>,
    /// The dispenser of parts.
    pub dispenser: Option<DispenserTable>,
    /// Light barriers in the order of
    /// [`ipc_types::EquipmentState::sensors`].
    pub sensors: Vec<SensorTable>,
    /// An object below this height is removed from the cell (m).
    pub clear_below_m: Option<f64>,
    /// Whether a reset of the task leaves it paused, with its arms on the way to their default
    /// pose.
    pub reset_pauses: bool,
    /// Disturbances of observation and drives.
    pub disturbance: Disturbance,
    /// Number of bins that the job needs: all of the cell, or fewer if the run limits them.
    pub bins: usize,
    /// Seed of everything random in this run.
    pub seed: u64,
    /// The table with the settings of the policies.
    pub task: TaskTable,
    /// Camera of a picture.
    pub camera: Camera,
    /// Source of the cell file, and of other files that it names.
    pub data: Data,
    /// Leaves of the task's tree that answer without being run (`--replace`).
    pub replace: Vec<Replace>,
}

/// An arm of a cell.
#[derive(Clone, Debug)]
pub struct ArmSpec {
    /// Name in the cell.
    pub name: String,
    /// The robot.
    pub robot: Robot,
    /// Pose of its base in the world frame.
    pub base: Isometry3<f64>,
    /// Controlled joints at the start (rad or m).
    pub home: Vec<f64>,
    /// Whether it follows planned paths where its goal is behind something (ADR 0021).
    pub planner: bool,
    /// Program with its controllers, if it is not the built-in one.
    pub controller: Option<String>,
}

/// A movable object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSpec {
    /// Name in the cell.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Mass (kg).
    pub mass: f64,
    /// Friction coefficient for this seed.
    pub friction: f64,
    /// Pose at the start for this seed, world frame.
    pub pose: Isometry3<f64>,
    /// Pose without the seed's variation, world frame.
    pub nominal: Isometry3<f64>,
    /// Largest deviation by which a seed may move it.
    pub spawn: SpawnArea,
    /// `name` of its table, which all objects of a series share.
    pub kind: String,
    /// Whether it is not in the simulation until the conveyor or the dispenser brings it.
    pub parked: bool,
    /// Whether motion policies can avoid it.
    pub obstacle: bool,
    /// Whether it may fall asleep while it still trembles.
    pub sleeps: bool,
    /// Damping of its turning (1/s).
    pub angular_damping: f64,
    /// Red, green, blue from 0 to 1.
    pub colour: [f64; 3],
}

/// A fixture.
#[derive(Clone, Debug, PartialEq)]
pub struct FixtureSpec {
    /// Name in the cell.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Pose in the world frame.
    pub pose: Isometry3<f64>,
    /// Friction coefficient.
    pub friction: f64,
    /// Whether it exists in physics; otherwise it only guides motions.
    pub solid: bool,
    /// Whether motion policies avoid it.
    pub obstacle: bool,
    /// Red, green, blue from 0 to 1.
    pub colour: [f64; 3],
}

impl Cell {
    /// Loads a demo. The seed places every object within its spawn area and
    /// picks its friction; `robot` replaces the robot of every arm.
    ///
    /// # Errors
    /// Returns [`ModelError`] for an unknown demo, and for the first file with an error.
    pub fn load(
        data: &Data,
        demo: &str,
        seed: u64,
        robot: Option<&RobotFiles>,
    ) -> Result<Self, ModelError> {
        Self::load_with(data, demo, seed, robot, &[])
    }

    /// As [`Cell::load`], with `settings` in place of numbers of the cell file.
    ///
    /// # Errors
    /// As [`Cell::load`], and for a key that is not the path of a number.
    pub fn load_with(
        data: &Data,
        demo: &str,
        seed: u64,
        robot: Option<&RobotFiles>,
        settings: &[Setting],
    ) -> Result<Self, ModelError> {
        // Checked before the file is read: a misspelt demo gets the list of the known ones.
        let demos = data.demos();
        if !demos.iter().any(|(name, _)| name == demo) {
            let names: Vec<&str> = demos.iter().map(|(name, _)| name.as_str()).collect();
            return Err(ModelError::UnknownName {
                what: "demo",
                name: demo.to_owned(),
                advice: suggest::advice(demo, &names),
            });
        }
        let file = format!("cells/{demo}.toml");
        let (text, name) = (data.read(&file)?, data.name_of(&file));
        if settings.is_empty() {
            return Self::from_text(data, demo, &name, &text, seed, robot);
        }
        let text = setting::apply(&name, &text, settings)?;
        // The settings are part of the file's name in messages: a refused value may be one of
        // them.
        let words: Vec<String> = settings.iter().map(Setting::to_string).collect();
        let name = format!("{name} (with {})", words.join(" "));
        Self::from_text(data, demo, &name, &text, seed, robot)
    }

    /// Loads a cell from the text of its file; `file` is its name in messages.
    ///
    /// # Errors
    /// As [`Cell::load`].
    pub fn from_text(
        data: &Data,
        name: &str,
        file: &str,
        text: &str,
        seed: u64,
        robot: Option<&RobotFiles>,
    ) -> Result<Self, ModelError> {
        let table: CellFile = toml_text::parse(file, text)?;
        // Ranges before robots: a wrong number of the cell file is reported without reading a
        // robot.
        check_file::check(file, text, &table)?;
        let mut arms = Vec::new();
        for (index, arm) in table.arms.iter().enumerate() {
            let loaded = match robot {
                Some(files) => Robot::from_files(files)?,
                None => named_robot(data, &Checker::new(file, text), index, &arm.robot)?,
            };
            // The home position of the file belongs to the robot of the file, not to one given
            // in its place.
            let home = match (&arm.home_joint_positions, robot) {
                (Some(home), None) => home.clone(),
                _ => loaded.home(),
            };
            check_file::home(file, text, index, &home, &loaded)?;
            arms.push(ArmSpec {
                name: arm.name.clone(),
                base: pose(arm.base_position_m, arm.base_yaw_rad),
                robot: loaded,
                home,
                planner: arm.planner,
                controller: arm.controller.clone(),
            });
        }
        // One generator, objects in the order of the file: inserting an object moves those
        // after it.
        let mut random = Random::new(seed);
        let objects: Vec<ObjectSpec> = table
            .objects
            .iter()
            .flat_map(|object| (0..object.count.unwrap_or(1)).map(move |index| (object, index)))
            .map(|(object, index)| place(object, index, &mut random))
            .collect();
        let kind = table.task.kind.clone();
        let named = |policy: String| policy_of_kind(&kind, policy);
        Ok(Self {
            name: name.to_owned(),
            bins: objects.iter().filter(|object| object.is_bin()).count(),
            seed,
            objects,
            conveyor: table.conveyor,
            dispenser: table.dispenser,
            sensors: table.sensors,
            clear_below_m: table.clear_below_m,
            reset_pauses: table.reset_pauses,
            disturbance: table.disturbance,
            fixtures: table.fixtures.iter().map(fixture).collect(),
            description: table.description,
            policies: table.policies.into_iter().map(named).collect(),
            default_policy: named(table.default_policy),
            time_limit_s: table.time_limit_s,
            arms,
            task: TaskTable::new(table.task, file, text),
            camera: table.camera,
            data: data.clone(),
            replace: Vec::new(),
        })
    }

    /// Text of another file in `cells/`, for instance a behaviour that the cell
    /// file names.
    ///
    /// # Errors
    /// Returns [`ModelError::Read`] if it is missing or unreadable.
    pub fn read(&self, name: &str) -> Result<Cow<'static, str>, ModelError> {
        self.data.read(&format!("cells/{name}"))
    }

    /// Name for messages of another file in `cells/`; see [`Data::name_of`].
    pub fn name_of(&self, name: &str) -> String {
        self.data.name_of(&format!("cells/{name}"))
    }

    /// Index of an object by name.
    ///
    /// # Errors
    /// Returns [`ModelError::UnknownName`] with the nearest name.
    pub fn object_index(&self, name: &str) -> Result<usize, ModelError> {
        let names: Vec<&str> = self
            .objects
            .iter()
            .map(|object| object.name.as_str())
            .collect();
        names
            .iter()
            .position(|known| *known == name)
            .ok_or_else(|| ModelError::UnknownName {
                what: "object",
                name: name.to_owned(),
                advice: suggest::advice(name, &names),
            })
    }

    /// Limits the job to `bins` bins.
    ///
    /// # Errors
    /// Returns [`ModelError::Value`] if the cell has fewer, or none.
    pub fn limit_bins(&mut self, bins: u32) -> Result<(), ModelError> {
        let wanted = bins as usize;
        if wanted == 0 || wanted > self.bins {
            let allowed = match self.bins {
                0 => "this cell has no bins".to_owned(),
                most => format!("1 to {most} are allowed"),
            };
            let file = self.name_of(&format!("{}.toml", self.name));
            return Err(ModelError::value(
                crate::error::Location::line(&file, None),
                "--bins",
                bins,
                allowed,
            ));
        }
        self.bins = wanted;
        Ok(())
    }

    /// Objects that motion policies can avoid, with their index, in the order of
    /// [`ipc_types::ArmGoal::object_mask`].
    pub fn obstacle_objects(&self) -> impl Iterator<Item = (usize, &ObjectSpec)> {
        let objects = self.objects.iter().enumerate();
        objects.filter(|(_, object)| object.obstacle)
    }

    /// Fixtures that motion policies avoid, in the order of
    /// [`ipc_types::ArmGoal::obstacle_mask`].
    pub fn obstacles(&self) -> impl Iterator<Item = &FixtureSpec> {
        self.fixtures.iter().filter(|fixture| fixture.obstacle)
    }
}

impl ObjectSpec {
    /// Whether it is a bin.
    pub fn is_bin(&self) -> bool {
        matches!(self.shape, Shape::Bin { .. })
    }

    /// Draws another pose within the spawn area.
    pub fn respawn(&mut self, random: &mut Random) {
        self.pose = vary(&self.nominal, self.spawn, random);
    }
}

/// The robot that an arm names; an unknown name is an error of the cell file.
fn named_robot(data: &Data, at: &Checker<'_>, arm: usize, name: &str) -> Result<Robot, ModelError> {
    let known = data.robot_names();
    if known.iter().any(|known| known == name) {
        return Robot::load(data, name);
    }
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let allowed = format!("no such robot; {}", suggest::advice(name, &known));
    Err(at.refuse(&format!("arm.{arm}.robot"), format!("'{name}'"), allowed))
}

/// An object of a table at its place for this seed. Four numbers are drawn for every object,
/// used or not: x, y, yaw, friction; a fifth if it can have several shapes. So a spread of 0
/// does not move the objects after it.
fn place(object: &ObjectTable, index: u32, random: &mut Random) -> ObjectSpec {
    let mut nominal = pose(object.position_m, object.yaw_rad);
    nominal.translation.vector += Vector3::from(object.pitch_m) * f64::from(index);
    let varied = vary(&nominal, object.spawn, random);
    let friction = object.friction + random.around_zero(object.friction_spread);
    let shape = match random_index(object.other_shapes.len() + 1, random) {
        0 => &object.shape,
        other => object.other_shapes.get(other - 1).unwrap_or(&object.shape),
    };
    ObjectSpec {
        name: numbered(object, index),
        shape: shape.clone(),
        mass: object.mass_kg,
        friction,
        kind: object.name.clone(),
        parked: object.parked,
        obstacle: object.obstacle,
        sleeps: object.sleeps,
        angular_damping: object.angular_damping,
        pose: varied,
        nominal,
        spawn: object.spawn,
        colour: object.colour,
    }
}

/// A number below `count`, each as likely; draws nothing if there is no choice.
fn random_index(count: usize, random: &mut Random) -> usize {
    if count < 2 {
        return 0;
    }
    usize::try_from(random.bits() % count as u64).unwrap_or(0)
}

fn vary(nominal: &Isometry3<f64>, spawn: SpawnArea, random: &mut Random) -> Isometry3<f64> {
    let (x, y) = (random.around_zero(spawn.x_m), random.around_zero(spawn.y_m));
    let turn = turn_about_z(random.around_zero(spawn.yaw_rad));
    Isometry3::from_parts(
        Translation3::new(x, y, 0.0) * nominal.translation,
        turn * nominal.rotation,
    )
}

fn fixture(table: &crate::cells::file::FixtureTable) -> FixtureSpec {
    FixtureSpec {
        name: table.name.clone(),
        shape: table.shape.clone(),
        pose: Isometry3::from_parts(
            Translation3::from(table.position_m),
            table
                .orientation_wxyz
                .map_or_else(|| turn_about_z(table.yaw_rad), unit),
        ),
        friction: table.friction,
        solid: table.solid,
        obstacle: table.obstacle,
        colour: table.colour,
    }
}

fn pose([x, y, z]: [f64; 3], yaw_rad: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), turn_about_z(yaw_rad))
}

/// The rotation of a quaternion w x y z, whose norm was checked to be 1.
fn unit([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z))
}

/// A turn about z (rad), with sine and cosine of `libm`, which are the same on every machine.
pub fn turn_about_z(angle: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
    Unit::new_unchecked(nalgebra::Quaternion::new(cos, 0.0, 0.0, sin))
}
