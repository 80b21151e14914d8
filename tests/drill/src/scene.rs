//! A scene that no file of the checkout has: robots, objects and a task, drawn from a seed.
#![expect(clippy::format_push_string, reason = "short texts, made once in a run")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use cell_model::robots::files::RobotFiles;
use cell_model::{Cell, Data};
use serde::{Deserialize, Serialize};

/// Name of the cell and its file.
pub const NAME: &str = "drill";
/// Scenes of this process have directories of their own: threads run at the same time.
static NEXT_DIR: AtomicU64 = AtomicU64::new(0);
/// Distance between the bases of two arms (m).
const ARM_DISTANCE_M: f64 = 3.0;

/// What a cell file and its robot say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Nothing has dynamics: objects rest, and joints are where their setpoints are.
    pub ideal: bool,
    /// Number of arms.
    pub arms: u8,
    /// The joints of each arm, from its base on; empty for a Franka.
    pub joints: Vec<Joint>,
    /// What can be moved.
    pub objects: Vec<Object>,
    /// Whether walls keep the objects together.
    pub tub: bool,
    /// What the task does.
    pub task: TaskPlan,
}

/// A joint of a generated robot, with the link that it moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// `revolute`, `continuous` or `prismatic`.
    pub kind: String,
    /// Its axis: 0, 1 or 2 for x, y or z.
    pub axis: u8,
    /// From zero to both limits (rad or m).
    pub range: f64,
    /// Length of the link along x and z (m).
    pub length_m: f64,
    /// Mass of the link (kg).
    pub mass_kg: f64,
}

/// An object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Its name.
    pub name: String,
    /// `box`, `cylinder`, `sphere`, `capsule` or `bin`.
    pub shape: String,
    /// Its edge, or twice its radius (m).
    pub size_m: f64,
    /// Its mass (kg).
    pub mass_kg: f64,
    /// Its friction coefficient.
    pub friction: f64,
    /// Its centre at the start (m).
    pub position_m: [f64; 3],
}

/// The task of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskPlan {
    /// Goals for all arms in turn, by a task that only counts; its memory has so many bytes.
    Stub {
        /// Bytes besides its counts.
        memory: u32,
        /// Whether the goals are poses, which RMPflow follows, or joint positions.
        poses: bool,
        /// The decision with which it fails; 0: never.
        #[serde(default)]
        fails_at: u64,
    },
    /// The arm follows its operator.
    Follow,
    /// The text of a behaviour file of this kind: `tree`, `machine` or `matrix`.
    File {
        /// The kind.
        kind: String,
        /// The text.
        text: String,
    },
}

/// The directory of the files of a scene; dropping it removes them.
#[derive(Debug)]
pub struct SceneDir(PathBuf);

impl Drop for SceneDir {
    fn drop(&mut self) {
        // What cannot be removed is left to the system.
        std::fs::remove_dir_all(&self.0).ok();
    }
}

impl Scene {
    /// The policy of its task.
    pub fn policy(&self) -> &'static str {
        match &self.task {
            TaskPlan::Stub { .. } => crate::stub::POLICY,
            TaskPlan::Follow => "follow",
            TaskPlan::File { kind, .. } => match kind.as_str() {
                "tree" => "json",
                "machine" => "table",
                _ => "matrix",
            },
        }
    }

    /// Writes its files to `dir`: `cells/drill.toml`, the task, and the robot.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write(&self, dir: &Path) -> std::io::Result<()> {
        let cells = dir.join("cells");
        std::fs::create_dir_all(&cells)?;
        std::fs::write(cells.join(format!("{NAME}.toml")), self.cell_file())?;
        if let TaskPlan::File { text, .. } = &self.task {
            std::fs::write(cells.join(self.behaviour()), text)?;
        }
        if let Some(urdf) = self.urdf() {
            std::fs::write(dir.join("robot.urdf"), urdf)?;
        }
        Ok(())
    }

    /// Loads it with `seed`; its files are there until the directory is dropped.
    ///
    /// # Errors
    /// In words, where the cell is refused.
    pub fn load(&self, seed: u64) -> Result<(Cell, SceneDir), String> {
        let own = NEXT_DIR.fetch_add(1, Ordering::Relaxed);
        let name = format!("robocell-drill-{}-{own}", std::process::id());
        let dir = SceneDir(std::env::temp_dir().join(name));
        let path = &dir.0;
        self.write(path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let data = Data::dir(path).with_robots_of(&Data::checkout());
        let robot = RobotFiles {
            urdf: path.join("robot.urdf"),
            ..RobotFiles::default()
        };
        let robot = (!self.joints.is_empty()).then_some(&robot);
        let cell = Cell::load(&data, NAME, seed, robot).map_err(|error| error.to_string())?;
        Ok((cell, dir))
    }

    fn behaviour(&self) -> &'static str {
        match &self.task {
            TaskPlan::File { kind, .. } if kind == "tree" => "drill.tree.json",
            TaskPlan::File { kind, .. } if kind == "machine" => "drill.machine.toml",
            _ => "drill.matrix.toml",
        }
    }

    /// The cell file.
    fn cell_file(&self) -> String {
        let policy = self.policy();
        let mut text = format!(
            "description = \"Drawn by the drill\"\npolicies = [\"{policy}\"]\n\
             default_policy = \"{policy}\"\ntime_limit_s = 3600.0\n\n\
             [camera]\neye_m = [2.0, 2.0, 2.0]\ntarget_m = [0.0, 0.0, 0.2]\n"
        );
        for arm in 0..self.arms {
            let y_m = ARM_DISTANCE_M * f64::from(arm);
            table(
                &mut text,
                &format!(
                    "[[arm]]\nname = \"arm_{arm}\"\nrobot = \"panda\"\n\
                     base_position_m = [0.0, {y_m:?}, 0.0]\n"
                ),
            );
        }
        for object in &self.objects {
            table(&mut text, &object.table());
        }
        if !self.objects.is_empty() {
            fixture(&mut text, "floor", [8.0, 12.0, 0.1], [0.0, 0.0, -0.05]);
        }
        if self.tub {
            for (name, x, y) in [("east", 0.5, 0.0), ("west", -0.5, 0.0)] {
                fixture(&mut text, name, [0.05, 1.0, 0.6], [TUB_X_M + x, y, 0.3]);
            }
            for (name, x, y) in [("north", 0.0, 0.5), ("south", 0.0, -0.5)] {
                fixture(&mut text, name, [1.0, 0.05, 0.6], [TUB_X_M + x, y, 0.3]);
            }
        }
        match &self.task {
            TaskPlan::Stub {
                memory,
                poses,
                fails_at,
            } => {
                let task = format!("[task]\nkind = \"{NAME}\"\nmemory = {memory}\n");
                table(
                    &mut text,
                    &format!("{task}poses = {poses}\nfails_at = {fails_at}\n"),
                );
            }
            TaskPlan::Follow => table(&mut text, "[task]\nkind = \"reach\"\n"),
            TaskPlan::File { kind, .. } => {
                let behaviour = self.behaviour();
                table(
                    &mut text,
                    &format!("[task]\nkind = \"{kind}\"\nbehaviour = \"{behaviour}\"\n"),
                );
                table(
                    &mut text,
                    "[task.place.mark]\nposition_m = [0.5, 0.3, 0.0]\n",
                );
            }
        }
        text
    }

    /// The robot, if it is a generated one.
    fn urdf(&self) -> Option<String> {
        if self.joints.is_empty() {
            return None;
        }
        let mut text = "<robot name=\"drawn\"><link name=\"link_0\"/>\n".to_owned();
        let mut length_m = 0.2;
        for (index, joint) in self.joints.iter().enumerate() {
            let (parent, child) = (index, index + 1);
            let effort = effort(&self.joints[index..]);
            joint.write(&mut text, (parent, child), length_m, effort);
            length_m = joint.length_m;
        }
        let last = self.joints.len();
        // The tip is away from the last axis, so that every joint can move it.
        let tip = [length_m, 0.1 * length_m, length_m];
        text += &format!(
            "<link name=\"tip\"/><joint name=\"to_tip\" type=\"fixed\">\
             <parent link=\"link_{last}\"/><child link=\"tip\"/>\
             <origin xyz=\"{} {} {}\"/></joint></robot>\n",
            tip[0], tip[1], tip[2]
        );
        Some(text)
    }
}

/// What the first of `joints` needs for all links from it on, stretched out, at 10 rad/s² or m/s²
/// (N·m or N).
// A weaker arm falls, and its joints leave their limits although every setpoint is within them.
fn effort(joints: &[Joint]) -> f64 {
    let mut reach_m = 0.0;
    let loads = joints.iter().map(|joint| {
        // Each link goes as far up as out.
        reach_m += std::f64::consts::SQRT_2 * joint.length_m;
        joint.mass_kg * (9.81 + 10.0 * reach_m) * reach_m.max(1.0)
    });
    // Several joints speed up at once.
    200.0 + 4.0 * loads.sum::<f64>()
}

/// Centre of the tub along x (m).
pub const TUB_X_M: f64 = 2.0;

fn table(text: &mut String, table: &str) {
    text.push('\n');
    text.push_str(table);
}

fn fixture(text: &mut String, name: &str, size_m: [f64; 3], position_m: [f64; 3]) {
    table(
        text,
        &format!(
            "[[fixture]]\nname = \"{name}\"\nshape = {{ kind = \"box\", size_m = {size_m:?} }}\n\
             position_m = {position_m:?}\nfriction = 0.8\nobstacle = false\n\
             colour = [0.5, 0.5, 0.5]\n"
        ),
    );
}

impl Object {
    fn table(&self) -> String {
        let (size, radius) = (self.size_m, self.size_m / 2.0);
        let shape = match self.shape.as_str() {
            "sphere" => format!("kind = \"sphere\", radius_m = {radius:?}"),
            "cylinder" | "capsule" => format!(
                "kind = \"{}\", radius_m = {radius:?}, height_m = {:?}",
                self.shape,
                0.4 * size
            ),
            "bin" => format!(
                "kind = \"bin\", size_m = [{size:?}, {size:?}, {radius:?}], wall_m = {:?}",
                size * 0.05
            ),
            _ => format!("kind = \"box\", size_m = [{size:?}, {size:?}, {size:?}]"),
        };
        let name = toml::Value::String(self.name.clone());
        format!(
            "[[object]]\nname = {name}\nshape = {{ {shape} }}\nmass_kg = {:?}\nfriction = {:?}\n\
             position_m = {:?}\ncolour = [0.8, 0.1, 0.1]\n",
            self.mass_kg, self.friction, self.position_m
        )
    }
}

impl Joint {
    /// Appends the joint, of at most `effort` (N·m or N), and its link; it is `from_m` away from
    /// the joint before.
    fn write(&self, text: &mut String, (parent, child): (usize, usize), from_m: f64, effort: f64) {
        let axis = ["1 0 0", "0 1 0", "0 0 1"][usize::from(self.axis % 3)];
        let (mass, length) = (self.mass_kg, self.length_m);
        // That of a rod, and of a thick one about its axis.
        let inertia = mass * length * length / 12.0;
        let limit = match self.kind.as_str() {
            "continuous" => format!("<limit velocity=\"2\" effort=\"{effort}\"/>"),
            _ => format!(
                "<limit lower=\"-{0}\" upper=\"{0}\" velocity=\"2\" effort=\"{effort}\"/>",
                self.range
            ),
        };
        // Writing to a text cannot fail.
        let _written = write!(
            text,
            "<link name=\"link_{child}\"><inertial><origin xyz=\"{} 0 {}\"/><mass value=\"{mass}\"/>\
             <inertia ixx=\"{inertia}\" iyy=\"{inertia}\" izz=\"{inertia}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\
             </inertial></link>\n<joint name=\"joint_{child}\" type=\"{}\">\
             <parent link=\"link_{parent}\"/><child link=\"link_{child}\"/>\
             <origin xyz=\"{from_m} 0 {from_m}\"/><axis xyz=\"{axis}\"/>{limit}</joint>\n",
            length / 2.0,
            length / 2.0,
            self.kind
        );
    }
}
