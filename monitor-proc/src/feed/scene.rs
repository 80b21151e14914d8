//! The cell as drawn by the page (docs/page-protocol.md, "the scene").

use std::path::Path;

use cell_model::{ArmSpec, Cell, Data, JointSpec, ModelError, Robot, Shape};
use cell_run::spec::RunSpec;
use nalgebra::Isometry3;
use serde_json::{Value, json};

use crate::feed::hello::DemoInfo;

/// Errors of a scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file of the cell.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The cell file, or a robot's.
    #[error("{file}: {reason}; the page shows the same files the cell was loaded from")]
    Toml {
        /// The file.
        file: String,
        /// Reason.
        reason: String,
    },
}

/// The scene of `cell`. `meshes` are the links of robots with a fetched mesh,
/// as `/ROBOT/LINK.glb`.
///
/// # Errors
///
/// When a file the cell was loaded from cannot be read again.
pub fn scene<'a>(
    cell: &Cell,
    spec: &RunSpec,
    meshes: &(impl Iterator<Item = &'a str> + Clone),
) -> Result<Value, SceneError> {
    let data = &cell.data;
    let file = format!("cells/{}.toml", cell.name);
    let mut table = toml_table(data, &file)?;
    // The page gets the whole table of the task: its panel differs by kind.
    let task = table.remove("task").unwrap_or(toml::Value::Boolean(false));
    let robots = robots_of(&table);
    let mut arms = Vec::new();
    for (index, arm) in cell.arms.iter().enumerate() {
        let named = spec.robot.as_ref().and_then(|files| files.name.as_deref());
        let robot = named.or_else(|| robots.get(index).map(String::as_str));
        let robot = robot.unwrap_or("");
        let urdf = urdf_text(data, spec, robot)?;
        arms.push(arm_json(arm, robot, &urdf, meshes.clone()));
    }
    let panel = task
        .get("kind")
        .and_then(toml::Value::as_str)
        .unwrap_or("")
        .to_owned();
    Ok(json!({
        "demo": cell.name,
        "description": cell.description,
        "camera": { "eye_m": cell.camera.eye_m, "target_m": cell.camera.target_m },
        "arms": arms,
        "objects": objects(cell),
        "fixtures": fixtures(cell),
        "bins": cell.bins,
        "conveyor": conveyor(cell),
        "dispenser": dispenser(cell),
        "sensors": sensors(cell),
        "task": task,
        "panel": panel,
        "start_event": waits_for_start(&panel),
    }))
}

fn fixtures(cell: &Cell) -> Vec<Value> {
    // Obstacles are numbered among themselves, as in the mask of a goal.
    let mut obstacles = 0..;
    let values = cell.fixtures.iter().map(|fixture| {
        let obstacle = if fixture.obstacle {
            obstacles.next()
        } else {
            None
        };
        json!({
            "name": fixture.name,
            "shape": shape(&fixture.shape),
            "pose": pose(&fixture.pose),
            "colour": fixture.colour,
            "solid": fixture.solid,
            "friction": fixture.friction,
            "obstacle": obstacle,
        })
    });
    values.collect()
}

fn objects(cell: &Cell) -> Vec<Value> {
    let values = cell.objects.iter().map(|object| {
        json!({
            "name": object.name,
            "shape": shape(&object.shape),
            "colour": object.colour,
            "mass_kg": object.mass,
            "parked": object.parked,
            "friction": object.friction,
            "kind": object.kind,
        })
    });
    values.collect()
}

fn conveyor(cell: &Cell) -> Option<Value> {
    let belt = cell.conveyor.as_ref()?;
    Some(json!({
        "fixture": belt.fixture,
        "velocity_m_s": belt.velocity_m_s,
        "brings": belt.supply.as_ref().map(|supply| &supply.objects),
    }))
}

fn dispenser(cell: &Cell) -> Option<Value> {
    let dispenser = cell.dispenser.as_ref()?;
    Some(json!({
        "position_m": dispenser.position_m,
        "spread_m": dispenser.spread_m,
        "per_drop": dispenser.per_drop,
    }))
}

fn sensors(cell: &Cell) -> Vec<Value> {
    let values = cell.sensors.iter().map(|sensor| {
        json!({
            "name": sensor.name,
            "position_m": sensor.position_m,
            "direction": sensor.direction,
            "range_m": sensor.range_m,
        })
    });
    values.collect()
}

/// All demos of `data` that can be loaded.
pub fn demos(data: &Data) -> Vec<DemoInfo> {
    let loaded = data.demos().into_iter().filter_map(|(name, description)| {
        // A demo that cannot be loaded is not offered.
        let cell = Cell::load(data, &name, 0, None).ok()?;
        Some(DemoInfo {
            name,
            description,
            policies: cell.policies,
            default_policy: cell.default_policy,
        })
    });
    loaded.collect()
}

/// Joints of the hand that follow its width, by arm.
pub fn fingers(cell: &Cell) -> Vec<usize> {
    let count = |arm: &ArmSpec| {
        arm.robot
            .gripper
            .as_ref()
            .map_or(0, |g| g.finger_joints.len())
    };
    cell.arms.iter().map(count).collect()
}

/// As [`fingers`], of a scene in JSON.
pub fn fingers_of(scene: &Value) -> Vec<usize> {
    let count = |arm: &Value| {
        arm["gripper"]["finger_joints"]
            .as_array()
            .map_or(0, Vec::len)
    };
    scene["arms"]
        .as_array()
        .into_iter()
        .flatten()
        .map(count)
        .collect()
}

/// Names of the arms of a scene in JSON.
pub fn arm_names(scene: &Value) -> Vec<String> {
    names(&scene["arms"])
}

/// Names of the objects of a scene in JSON.
pub fn object_names(scene: &Value) -> Vec<String> {
    names(&scene["objects"])
}

fn names(list: &Value) -> Vec<String> {
    let values = list.as_array().into_iter().flatten();
    values
        .map(|one| one["name"].as_str().unwrap_or_default().to_owned())
        .collect()
}

/// Links of a robot among `meshes`, which are `/ROBOT/LINK.glb`.
pub fn links_with_mesh<'a>(robot: &str, meshes: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let link = |path: &'a str| {
        let (of, link) = path
            .strip_prefix('/')?
            .strip_suffix(".glb")?
            .split_once('/')?;
        (of == robot).then_some(link)
    };
    meshes.filter_map(link).collect()
}

/// Demos whose task waits for its start event.
fn waits_for_start(panel: &str) -> bool {
    matches!(panel, "palletize" | "fill_bin" | "bin_stack")
}

fn toml_table(data: &Data, file: &str) -> Result<toml::Table, SceneError> {
    let text = data.read(file)?;
    text.parse()
        .map_err(|error: toml::de::Error| SceneError::Toml {
            file: file.to_owned(),
            reason: error.message().to_owned(),
        })
}

/// Folder in `robots/` of every arm.
fn robots_of(table: &toml::Table) -> Vec<String> {
    let arms = table.get("arm").and_then(toml::Value::as_array);
    let name = |arm: &toml::Value| {
        arm.get("robot")
            .and_then(toml::Value::as_str)
            .map(str::to_owned)
    };
    arms.into_iter()
        .flatten()
        .map(|arm| name(arm).unwrap_or_default())
        .collect()
}

fn urdf_text(data: &Data, spec: &RunSpec, robot: &str) -> Result<String, SceneError> {
    // A robot given by its files on the command line replaces that of the cell.
    if let Some(files) = spec.robot.as_ref().filter(|files| files.name.is_none()) {
        return Ok(cell_model::data::read_text(Path::new(&files.urdf))?);
    }
    let table = toml_table(data, &format!("robots/{robot}/robot.toml"))?;
    let urdf = table
        .get("urdf")
        .and_then(toml::Value::as_str)
        .unwrap_or_default();
    Ok(data.read(&format!("robots/{robot}/{urdf}"))?.into_owned())
}

fn arm_json<'a>(
    arm: &ArmSpec,
    folder: &str,
    urdf: &str,
    meshes: impl Iterator<Item = &'a str>,
) -> Value {
    let robot = &arm.robot;
    let (tool_link, tool) = tool(robot);
    let fingers: &[usize] = robot.gripper.as_ref().map_or(&[], |g| &g.finger_joints);
    let joints = robot
        .arm_joints
        .iter()
        .map(|joint| (joint, arm.home.as_slice()));
    // Fingers after the arm's joints: the recording finds them by this order.
    let joints = joints.chain(fingers.iter().map(|joint| (joint, [].as_slice())));
    let joints = joints
        .enumerate()
        .filter_map(|(place, (joint, home))| joint_json(robot, *joint, home.get(place).copied()));
    let fingers = robot.gripper.as_ref().map(|gripper| {
        let names = fingers.iter().filter_map(|joint| joint_name(robot, *joint));
        json!({
            "kind": "parallel",
            "max_width_m": gripper.max_width,
            "finger_joints": names.collect::<Vec<_>>(),
        })
    });
    let suction = robot.suction.as_ref().map(|suction| {
        json!({
            "kind": "suction",
            "max_width_m": 0.0,
            "finger_joints": [],
            "axis": suction.axis.as_slice(),
            "force_limit_n": suction.force_limit,
            "torque_limit_n_m": suction.torque_limit,
        })
    });
    // For pictures of robots without meshes.
    let spheres = robot.spheres.iter().map(|sphere| {
        let center = [sphere.center.x, sphere.center.y, sphere.center.z];
        json!({ "link": sphere.frame, "center": center, "radius": sphere.radius })
    });
    let links = links_with_mesh(folder, meshes);
    let base = pose(&arm.base);
    json!({
        "name": arm.name,
        "robot": if folder.is_empty() { &robot.name } else { folder },
        "base": { "position": &base[..3], "orientation_wxyz": &base[3..] },
        "urdf": urdf,
        "joints": joints.collect::<Vec<_>>(),
        "arm_joints": robot.arm_joints.len(),
        "gripper": fingers.or(suction),
        "tool_link": tool_link,
        "tool": pose(&tool),
        "spheres": spheres.collect::<Vec<_>>(),
        "meshes": links,
    })
}

fn joint_name(robot: &Robot, joint: usize) -> Option<&str> {
    robot
        .chain
        .joints()
        .get(joint)
        .map(|joint| joint.name.as_str())
}

fn joint_json(robot: &Robot, joint: usize, home: Option<f64>) -> Option<Value> {
    let spec: &JointSpec = robot.joints.get(joint)?;
    let kind = match robot.chain.joints().get(joint)?.kind {
        rmp::JointKind::Revolute => "revolute",
        rmp::JointKind::Prismatic => "prismatic",
    };
    Some(json!({
        "name": joint_name(robot, joint),
        "kind": kind,
        "lower": spec.lower,
        "upper": spec.upper,
        "velocity": spec.velocity,
        "acceleration": spec.acceleration,
        "effort": spec.effort,
        "home": home.unwrap_or(spec.home),
    }))
}

/// The link that carries the tool, and the tool's pose in it.
fn tool(robot: &Robot) -> (&str, Isometry3<f64>) {
    let Some(frame) = robot.chain.frames().get(robot.tcp_frame) else {
        return ("", Isometry3::identity());
    };
    // Links are numbered from the base, which no joint moves.
    let link = robot.links.get(frame.joint.map_or(0, |joint| joint + 1));
    (link.map_or("", |link| &link.name), frame.pose)
}

fn pose(pose: &Isometry3<f64>) -> [f64; 7] {
    let (t, q) = (&pose.translation, &pose.rotation);
    [t.x, t.y, t.z, q.w, q.i, q.j, q.k]
}

fn shape(shape: &Shape) -> Value {
    match *shape {
        Shape::Box { size_m } => json!({ "kind": "box", "size_m": size_m }),
        Shape::Sphere { radius_m } => json!({ "kind": "sphere", "radius_m": radius_m }),
        Shape::Cylinder { radius_m, height_m } => {
            json!({ "kind": "cylinder", "radius_m": radius_m, "length_m": height_m })
        }
        Shape::Capsule { radius_m, height_m } => {
            json!({ "kind": "capsule", "radius_m": radius_m, "length_m": height_m })
        }
        Shape::Bin { size_m, wall_m } => {
            json!({ "kind": "bin", "size_m": size_m, "wall_m": wall_m })
        }
    }
}
