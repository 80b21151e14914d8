//! Reader of XRDF 1.0 and 2.0: the controlled joints with their limits, tool frames, and the
//! spheres that represent the robot in collision checks.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::error::ModelError;
use crate::robots::rmpflow::yaml;
use rmp::CollisionSphere;

/// Allowed limits of acceleration (rad/s² or m/s²), and of jerk.
pub(crate) const ACCELERATION: (f64, f64) = (1e-6, 1e5);
pub(crate) const JERK: (f64, f64) = (1e-6, 1e7);

/// The content of an XRDF.
#[derive(Clone, Debug, PartialEq)]
pub struct Xrdf {
    /// Default positions of joints by name (rad or m); not every joint has one.
    pub default_joint_positions: BTreeMap<String, f64>,
    /// Controlled joints in order.
    pub joint_names: Vec<String>,
    /// Acceleration limit of each controlled joint (rad/s² or m/s²); empty if the file has
    /// none, as in some robot descriptions of Lula.
    pub acceleration_limits: Vec<f64>,
    /// Jerk limit of each controlled joint (rad/s³ or m/s³), or empty.
    pub jerk_limits: Vec<f64>,
    /// Frames for tools; the first one is the default.
    pub tool_frames: Vec<String>,
    /// Spheres against the world, by frame in alphabetic order.
    pub world_spheres: Vec<CollisionSphere>,
    /// Spheres against the robot itself.
    pub self_spheres: Vec<CollisionSphere>,
    /// Pairs of frames whose spheres are not checked against each other.
    pub self_ignore: Vec<(String, String)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    #[serde(default)]
    #[allow(dead_code, reason = "the versions read here agree on these keys")]
    format_version: Option<IgnoredAny>,
    #[serde(default)]
    modifiers: Option<IgnoredAny>,
    #[serde(default)]
    default_joint_positions: BTreeMap<String, f64>,
    cspace: Cspace,
    #[serde(default)]
    tool_frames: Vec<String>,
    #[serde(default, alias = "collision")]
    world_collision: Option<Collision>,
    #[serde(default)]
    self_collision: Option<Collision>,
    #[serde(default)]
    geometry: BTreeMap<String, Geometry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Cspace {
    joint_names: Vec<String>,
    acceleration_limits: Vec<f64>,
    jerk_limits: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Collision {
    geometry: String,
    #[serde(default)]
    buffer_distance: BTreeMap<String, f64>,
    #[serde(default)]
    ignore: BTreeMap<String, Vec<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Geometry {
    #[serde(default)]
    spheres: BTreeMap<String, Vec<Sphere>>,
    #[serde(default)]
    clone: Option<Names>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sphere {
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Names {
    One(String),
    Many(Vec<String>),
}

/// Reads an XRDF. `file` is the name used in errors.
///
/// # Errors
/// Returns [`ModelError`] for bad YAML, another format, a missing or unknown key, a number that
/// is not finite or out of range, and geometry that refers to itself.
pub fn parse(file: &str, text: &str) -> Result<Xrdf, ModelError> {
    let read: File = yaml::parse(file, text)?;
    let reader = Reader { file, text };
    if read.format != "xrdf" {
        return Err(reader.refuse("format", &read.format, "only 'xrdf' is allowed"));
    }
    // Ignoring modifiers would load another robot than the file describes.
    if read.modifiers.is_some() {
        let advice = "not supported; put its frames into the URDF and remove it";
        return Err(reader.refuse("modifiers", "given", advice));
    }
    reader.check_cspace(&read.cspace)?;
    for (name, &position) in &read.default_joint_positions {
        let key = format!("default_joint_positions.{name}");
        reader.number(&key, position, -100.0, 100.0)?;
    }
    let world_spheres = reader.spheres(
        "world_collision",
        read.world_collision.as_ref(),
        &read.geometry,
    )?;
    let self_spheres = reader.spheres(
        "self_collision",
        read.self_collision.as_ref(),
        &read.geometry,
    )?;
    let ignore = read.self_collision.map(|c| c.ignore).unwrap_or_default();
    Ok(Xrdf {
        default_joint_positions: read.default_joint_positions,
        joint_names: read.cspace.joint_names,
        acceleration_limits: read.cspace.acceleration_limits,
        jerk_limits: read.cspace.jerk_limits,
        tool_frames: read.tool_frames,
        world_spheres,
        self_spheres,
        self_ignore: pairs(ignore),
    })
}

fn pairs(ignore: BTreeMap<String, Vec<String>>) -> Vec<(String, String)> {
    let mut pairs = Vec::new();
    for (frame, others) in ignore {
        pairs.extend(others.into_iter().map(|other| (frame.clone(), other)));
    }
    pairs
}

/// Numbers of a file with the line of their key.
pub(crate) struct Reader<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
}

impl Reader<'_> {
    pub(crate) fn refuse(
        &self,
        key: &str,
        value: impl std::fmt::Display,
        allowed: impl Into<String>,
    ) -> ModelError {
        yaml::refuse(self.file, self.text, key, value, allowed)
    }

    pub(crate) fn number(
        &self,
        key: &str,
        value: f64,
        low: f64,
        high: f64,
    ) -> Result<(), ModelError> {
        // `contains` refuses NaN as well, which YAML can write.
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(self.refuse(key, value, format!("{low} to {high} is allowed")))
    }

    /// Checks the names of controlled joints.
    pub(crate) fn check_names(&self, key: &str, names: &[String]) -> Result<(), ModelError> {
        let joints = names.len();
        if joints == 0 || joints > rmp::MAX_JOINTS {
            let allowed = format!("1 to {} names are allowed", rmp::MAX_JOINTS);
            return Err(self.refuse(key, format!("{joints} names"), allowed));
        }
        Ok(())
    }

    /// Checks a list with a number for each of `joints` controlled joints.
    pub(crate) fn numbers(
        &self,
        key: &str,
        values: &[f64],
        joints: usize,
        (low, high): (f64, f64),
    ) -> Result<(), ModelError> {
        if values.len() != joints {
            let allowed = format!("{joints} are needed, one for each controlled joint");
            return Err(self.refuse(key, format!("{} numbers", values.len()), allowed));
        }
        let mut values = values.iter().enumerate();
        values.try_for_each(|(index, &value)| {
            self.number(&format!("{key}[{index}]"), value, low, high)
        })
    }

    fn check_cspace(&self, cspace: &Cspace) -> Result<(), ModelError> {
        self.check_names("cspace.joint_names", &cspace.joint_names)?;
        let joints = cspace.joint_names.len();
        let (acceleration, jerk) = (&cspace.acceleration_limits, &cspace.jerk_limits);
        self.numbers(
            "cspace.acceleration_limits",
            acceleration,
            joints,
            ACCELERATION,
        )?;
        self.numbers("cspace.jerk_limits", jerk, joints, JERK)
    }

    /// Spheres of a section, clones included, with its buffers added to the radii.
    fn spheres(
        &self,
        section: &str,
        collision: Option<&Collision>,
        geometry: &BTreeMap<String, Geometry>,
    ) -> Result<Vec<CollisionSphere>, ModelError> {
        let Some(collision) = collision else {
            return Ok(Vec::new());
        };
        let mut spheres = Vec::new();
        let mut open = Vec::new();
        self.collect(
            section,
            &collision.geometry,
            geometry,
            &mut open,
            &mut spheres,
        )?;
        for sphere in &mut spheres {
            if let Some(&buffer) = collision.buffer_distance.get(&sphere.frame) {
                self.number(
                    &format!("{section}.buffer_distance.{}", sphere.frame),
                    buffer,
                    -1.0,
                    10.0,
                )?;
                // A negative buffer may be larger than the radius.
                sphere.radius = (sphere.radius + buffer).max(0.0);
            }
        }
        Ok(spheres)
    }

    fn collect(
        &self,
        section: &str,
        name: &str,
        geometry: &BTreeMap<String, Geometry>,
        open: &mut Vec<String>,
        spheres: &mut Vec<CollisionSphere>,
    ) -> Result<(), ModelError> {
        let key = format!("{section}.geometry");
        let Some(found) = geometry.get(name) else {
            let known: Vec<&str> = geometry.keys().map(String::as_str).collect();
            let advice = format!("no such geometry; {}", crate::suggest::advice(name, &known));
            return Err(self.refuse(&key, name, advice));
        };
        // A geometry that clones itself would never end.
        if open.iter().any(|other| other == name) {
            return Err(self.refuse(&key, name, "it clones itself; remove the circle"));
        }
        open.push(name.to_owned());
        for (frame, list) in &found.spheres {
            for (index, sphere) in list.iter().enumerate() {
                let key = format!("geometry.{name}.spheres.{frame}[{index}]");
                spheres.push(self.sphere(&key, frame, sphere)?);
            }
        }
        let clones = match &found.clone {
            Some(Names::One(one)) => std::slice::from_ref(one),
            Some(Names::Many(many)) => many.as_slice(),
            None => &[],
        };
        for clone in clones {
            self.collect(section, clone, geometry, open, spheres)?;
        }
        open.pop();
        Ok(())
    }

    pub(crate) fn sphere(
        &self,
        key: &str,
        frame: &str,
        sphere: &Sphere,
    ) -> Result<CollisionSphere, ModelError> {
        for &value in &sphere.center {
            self.number(&format!("{key}.center"), value, -100.0, 100.0)?;
        }
        self.number(&format!("{key}.radius"), sphere.radius, 0.0, 100.0)?;
        Ok(CollisionSphere {
            frame: frame.to_owned(),
            center: sphere.center.into(),
            radius: sphere.radius,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PANDA: &str = include_str!("../../../../../robots/panda/panda.xrdf");

    #[test]
    fn our_own_robot_is_read() {
        let xrdf = parse("panda.xrdf", PANDA).unwrap();
        assert_eq!(xrdf.joint_names.len(), 7);
        assert_eq!(xrdf.jerk_limits[1], 3750.0);
        assert_eq!(xrdf.default_joint_positions["panda_joint4"], -2.87);
        assert_eq!(xrdf.world_spheres.len(), 56);
        assert_eq!(xrdf.self_spheres.len(), 57);
        let pair = ("panda_link0".to_owned(), "panda_link1".to_owned());
        assert!(xrdf.self_ignore.contains(&pair));
    }

    #[test]
    fn mistakes_name_key_and_line() {
        let cases = [
            ("jerk_limits", "jerk_limit", "did you mean 'jerk_limits'"),
            (
                "[7500.0, 3750.0",
                "[-7500.0, 3750.0",
                "cspace.jerk_limits[0] is -7500",
            ),
            (
                "[7500.0, 3750.0",
                "[.inf, 3750.0",
                "cspace.jerk_limits[0] is inf",
            ),
            ("[7500.0, 3750.0, ", "[", "5 numbers; 7 are needed"),
            (
                "panda_joint2: -1.3",
                "panda_joint2: .nan",
                "panda_joint2 is NaN",
            ),
            (
                "geometry: arm_and_hand",
                "geometry: arm_and_hant",
                "did you mean 'arm_and_hand'",
            ),
            ("format: xrdf", "format: rmpflow", "only 'xrdf'"),
        ];
        for (from, to, wanted) in cases {
            let text = PANDA.replacen(from, to, 1);
            assert_ne!(text, PANDA, "{from}");
            let error = parse("a.xrdf", &text).unwrap_err().to_string();
            assert!(error.contains(wanted), "{error}");
            assert!(error.starts_with("a.xrdf:"), "{error}");
        }
    }

    #[test]
    fn geometry_that_clones_itself_is_refused() {
        let text = "{format: xrdf, cspace: {joint_names: [a], acceleration_limits: [1], \
                    jerk_limits: [1]}, world_collision: {geometry: g}, geometry: {g: {clone: g}}}";
        let error = parse("a.xrdf", text).unwrap_err().to_string();
        assert!(error.contains("clones itself"), "{error}");
    }

    #[test]
    fn buffers_grow_spheres() {
        let text = "{format: xrdf, cspace: {joint_names: [a], acceleration_limits: [1], \
                    jerk_limits: [1]}, world_collision: {geometry: g, buffer_distance: {f: 0.5}}, \
                    geometry: {g: {spheres: {f: [{center: [0, 0, 1], radius: 0.25}]}}}}";
        assert_eq!(parse("a.xrdf", text).unwrap().world_spheres[0].radius, 0.75);
    }
}
