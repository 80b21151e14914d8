//! Isaac Sim's files of a robot: `config.json`, which names the others, and the robot
//! description of Lula, with the content of an XRDF.
//!
//! A description has no section about self-collision. A sphere with a radius of zero or less is
//! switched off, as in Isaac Sim.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rmp::CollisionSphere;
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::error::{Location, ModelError};
use crate::robots::files::RobotFiles;
use crate::robots::motion::read;
use crate::robots::rmpflow::yaml;
use crate::robots::xrdf::{ACCELERATION, JERK, Reader, Sphere, Xrdf};

/// Keys of which every description has one, and that no XRDF has.
const OWN_KEYS: [&str; 3] = ["default_q:", "collision_spheres:", "cspace_to_urdf_rules:"];

#[derive(Deserialize)]
struct Config {
    end_effector_frame_name: String,
    relative_asset_paths: AssetPaths,
}

#[derive(Deserialize)]
struct AssetPaths {
    #[serde(rename = "robot_description_path")]
    description: PathBuf,
    #[serde(rename = "urdf_path")]
    urdf: PathBuf,
    /// `None`: the general tuning.
    #[serde(rename = "rmpflow_config_path", default)]
    rmpflow: Option<PathBuf>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    #[serde(default)]
    #[allow(dead_code, reason = "all versions agree on these keys")]
    api_version: Option<IgnoredAny>,
    cspace: Vec<String>,
    #[serde(default)]
    #[allow(dead_code, reason = "the root of the URDF is the base here")]
    root_link: Option<IgnoredAny>,
    #[serde(default)]
    #[allow(dead_code, reason = "known, and of no effect here")]
    subtree_root_link: Option<IgnoredAny>,
    #[serde(default)]
    #[allow(dead_code, reason = "known, and of no effect here")]
    composite_task_spaces: Option<IgnoredAny>,
    default_q: Vec<f64>,
    #[serde(default)]
    acceleration_limits: Option<Vec<f64>>,
    #[serde(default)]
    jerk_limits: Option<Vec<f64>>,
    #[serde(default)]
    cspace_to_urdf_rules: Option<Vec<Rule>>,
    #[serde(default)]
    collision_spheres: Option<Vec<BTreeMap<String, Vec<Sphere>>>>,
}

/// Position of a joint that is not controlled.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Rule {
    name: String,
    #[serde(rename = "rule")]
    kind: String,
    value: f64,
}

/// Whether a text is a description of Lula and not an XRDF.
pub(crate) fn is_description(text: &str) -> bool {
    text.lines()
        // At the start of a line: an indented key is one of another table.
        .any(|line| OWN_KEYS.iter().any(|key| line.starts_with(key)))
}

/// The files that a `config.json` names, with its tool frame. Its other keys are parameters of
/// Isaac Sim's controller, and are not used.
///
/// # Errors
/// Returns [`ModelError`] if the file is missing, not JSON, or lacks a key.
pub(crate) fn read_config(path: &Path) -> Result<RobotFiles, ModelError> {
    let (file, text) = read(path)?;
    config(&file, &text, path.parent().unwrap_or(Path::new("")))
}

fn config(file: &str, text: &str, dir: &Path) -> Result<RobotFiles, ModelError> {
    let config: Config = serde_json::from_str(text).map_err(|error| ModelError::Syntax {
        place: Location::line(file, Some(error.line())),
        message: format!("no config.json of a robot of Isaac Sim: {error}"),
    })?;
    let of = |relative: &Path| dir.join(relative);
    let paths = &config.relative_asset_paths;
    Ok(RobotFiles {
        name: None,
        urdf: of(&paths.urdf),
        xrdf: Some(of(&paths.description)),
        rmpflow: paths.rmpflow.as_deref().map(of),
        tip: Some(config.end_effector_frame_name),
    })
}

/// Reads a robot description. `file` is the name used in errors.
///
/// # Errors
/// Returns [`ModelError`] for bad YAML, a missing or unknown key, and numbers that are not
/// finite, out of range, or not one for each joint.
pub(crate) fn parse(file: &str, text: &str) -> Result<Xrdf, ModelError> {
    let read: Description = yaml::parse(file, text)?;
    let reader = Reader { file, text };
    reader.check_names("cspace", &read.cspace)?;
    let joints = read.cspace.len();
    reader.numbers("default_q", &read.default_q, joints, (-100.0, 100.0))?;
    let mut default_joint_positions: BTreeMap<String, f64> = read
        .cspace
        .iter()
        .cloned()
        .zip(read.default_q.iter().copied())
        .collect();
    for rule in read.cspace_to_urdf_rules.unwrap_or_default() {
        if rule.kind != "fixed" {
            let allowed = format!("only 'fixed' is supported; of joint '{}'", rule.name);
            return Err(reader.refuse("cspace_to_urdf_rules", &rule.kind, allowed));
        }
        reader.number("cspace_to_urdf_rules.value", rule.value, -100.0, 100.0)?;
        default_joint_positions.insert(rule.name, rule.value);
    }
    let limits = |key: &str, values: Option<Vec<f64>>, range| {
        let values = values.unwrap_or_default();
        if !values.is_empty() {
            reader.numbers(key, &values, joints, range)?;
        }
        Ok(values)
    };
    let acceleration_limits = limits(
        "acceleration_limits",
        read.acceleration_limits,
        ACCELERATION,
    )?;
    let jerk_limits = limits("jerk_limits", read.jerk_limits, JERK)?;
    let spheres = spheres(&reader, read.collision_spheres.unwrap_or_default())?;
    Ok(Xrdf {
        default_joint_positions,
        joint_names: read.cspace,
        acceleration_limits,
        jerk_limits,
        // The tool is in `config.json`.
        tool_frames: Vec::new(),
        world_spheres: spheres,
        self_spheres: Vec::new(),
        self_ignore: Vec::new(),
    })
}

fn spheres(
    reader: &Reader<'_>,
    links: Vec<BTreeMap<String, Vec<Sphere>>>,
) -> Result<Vec<CollisionSphere>, ModelError> {
    let mut spheres = Vec::new();
    for (frame, list) in links.into_iter().flatten() {
        for (index, mut sphere) in list.into_iter().enumerate() {
            // Zero before the check of ranges, which refuses negative radii; then left out.
            if sphere.radius <= 0.0 {
                sphere.radius = 0.0;
            }
            let key = format!("collision_spheres.{frame}[{index}]");
            let sphere = reader.sphere(&key, &frame, &sphere)?;
            spheres.extend((sphere.radius > 0.0).then_some(sphere));
        }
    }
    Ok(spheres)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: &str = "api_version: 1.0\ncspace: [a, b]\nroot_link: world\n\
        default_q: [0.5, -1.0]\nacceleration_limits: [10, 20]\njerk_limits: [1000, 2000]\n\
        cspace_to_urdf_rules:\n  - {name: finger, rule: fixed, value: 0.02}\n\
        collision_spheres:\n  - link_1:\n    - \"center\": [0, 0, 0.1]\n      \"radius\": 0.05\n\
        \x20   - \"center\": [0, 0, 0.2]\n      \"radius\": -1.0\n";

    #[test]
    fn a_description_says_what_an_xrdf_says() {
        assert!(is_description(ARM));
        let read = parse("arm.yaml", ARM).unwrap();
        assert_eq!(read.joint_names, ["a", "b"]);
        assert_eq!(read.default_joint_positions["finger"], 0.02);
        assert_eq!(read.jerk_limits, [1000.0, 2000.0]);
        // The sphere of negative radius is switched off.
        assert_eq!(read.world_spheres.len(), 1);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let cases = [
            ("[0.5, -1.0]", "[0.5]", "arm.yaml:4: default_q is 1 numbers"),
            ("[10, 20]", "[10, -2]", "acceleration_limits[1] is -2"),
            ("rule: fixed", "rule: mimic", "only 'fixed'"),
            ("root_link", "rot_link", "did you mean 'root_link'"),
            ("0.1]", ".nan]", "collision_spheres.link_1[0]"),
        ];
        for (from, to, wanted) in cases {
            let text = ARM.replacen(from, to, 1);
            assert_ne!(text, ARM, "{from}");
            let error = parse("arm.yaml", &text).unwrap_err().to_string();
            assert!(error.contains(wanted), "{error}");
        }
    }

    #[test]
    fn a_config_names_the_other_files() {
        let text = "{\"end_effector_frame_name\": \"tool\", \"maximum_substep_size\": 0.01,
            \"relative_asset_paths\": {\"urdf_path\": \"../a.urdf\",
            \"robot_description_path\": \"a.yaml\", \"rmpflow_config_path\": \"b.yaml\"}}";
        let files = config("config.json", text, Path::new("/robots/a/rmpflow")).unwrap();
        assert_eq!(files.urdf, Path::new("/robots/a/rmpflow/../a.urdf"));
        assert_eq!(files.tip.as_deref(), Some("tool"));
        let lacks = "{\"end_effector_frame_name\": \"tool\",\n\"x\": 1}";
        let error = config("config.json", lacks, Path::new("")).unwrap_err();
        let error = error.to_string();
        assert!(error.contains("relative_asset_paths"), "{error}");
        assert!(error.starts_with("config.json:2: "), "{error}");
    }
}
