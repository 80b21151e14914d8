//! A cell ready to run: robots loaded, objects placed by the seed.

use std::borrow::Cow;

use crate::cells::check_file;
use crate::cells::file::{CellFile, LightTable};
use crate::cells::replace::Replace;
use crate::cells::setting::{self, Setting};
use crate::cells::task_table::TaskTable;
use crate::data::Data;
use crate::error::ModelError;
use crate::random::Random;
use crate::robots::files::RobotFiles;
use crate::runs::policy_name::policy_of_kind;
use crate::runs::policy_server::PolicyServer;
use crate::{suggest, toml_text};

mod arm;
mod camera;
mod fixture;
mod object;
mod pose;

use arm::load_arm;
use fixture::fixture;
use object::place;

pub use crate::cells::file::{
    Camera, ConveyorTable, DispenserTable, Disturbance, SensorTable, SpawnArea, SupplyTable,
};
pub use arm::{ArmSpec, CLIENT_CONTROLLER};
pub use camera::{CameraMount, CameraSpec, MAX_PIXELS, looking};
pub use fixture::FixtureSpec;
pub use object::ObjectSpec;
pub use pose::turn_about_z;

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
    /// The first view of the page.
    pub camera: Camera,
    /// Cameras whose pictures are computed, `front` first.
    pub cameras: Vec<CameraSpec>,
    /// The light of their pictures.
    pub light: LightTable,
    /// Source of the cell file, and of other files that it names.
    pub data: Data,
    /// Leaves of the task's tree that answer without being run (`--replace`).
    pub replace: Vec<Replace>,
    /// How a policy behind a socket is used.
    pub policy_server: Option<PolicyServer>,
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
            arms.push(load_arm(data, (file, text), (index, arm), robot)?);
        }
        let cameras = camera::cameras(file, text, &table, &arms)?;
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
            cameras,
            light: table.light,
            data: data.clone(),
            replace: Vec::new(),
            policy_server: None,
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
