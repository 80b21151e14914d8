//! Joints that copy another one (`mimic`): the bars of a parallelogram, coupled sections of a
//! telescope, the second finger of a hand.
//!
//! Such a joint has no independent position. Its range is limited by that of the joint that it
//! follows, and a configuration of an arm has no entry for it.

use std::collections::BTreeMap;

use rmp::{Joint, Mimic};
use urdf_rs::JointType;

use crate::error::{Location, ModelError};
use crate::robots::robot::Robot;
use crate::robots::urdf_clean::Lines;
use crate::robots::urdf_limits::UrdfLimits;

/// Smallest share of its range that a followed joint keeps; with less the limits of its
/// followers are ignored.
const LEAST_RANGE: f64 = 0.01;

/// By name of a joint: the joint that it follows and that follows none itself, with multiplier
/// and offset.
pub(super) type Followed<'a> = BTreeMap<&'a str, (&'a str, f64, f64)>;

/// Finds the joint that moves each joint that copies another one, over several steps.
///
/// # Errors
/// Returns [`ModelError::Value`] with the line of a joint that copies itself, or of one in a
/// circle.
pub(super) fn resolve<'a>(
    file: &str,
    lines: &Lines,
    robot: &'a urdf_rs::Robot,
) -> Result<Followed<'a>, ModelError> {
    let copies: BTreeMap<&str, &urdf_rs::Mimic> = robot
        .joints
        .iter()
        .filter_map(|joint| Some((joint.name.as_str(), joint.mimic.as_ref()?)))
        .collect();
    let mut followed = Followed::new();
    for (&name, mimic) in &copies {
        let mut way = vec![name];
        let (mut multiplier, mut offset) = (1.0, 0.0);
        let mut next = Some(*mimic);
        while let Some(mimic) = next {
            offset += multiplier * mimic.offset.unwrap_or(0.0);
            multiplier *= mimic.multiplier.unwrap_or(1.0);
            // A circle would never end this loop.
            let is_known = way.contains(&mimic.joint.as_str());
            way.push(&mimic.joint);
            if is_known {
                return Err(circle(file, lines, &way));
            }
            next = copies.get(mimic.joint.as_str()).copied();
        }
        let first = way.last().copied().unwrap_or_default();
        followed.insert(name, (first, multiplier, offset));
    }
    Ok(followed)
}

fn circle(file: &str, lines: &Lines, way: &[&str]) -> ModelError {
    let name = way.last().copied().unwrap_or_default();
    // The joints before the circle only lead to it.
    let begin = way.iter().position(|one| *one == name).unwrap_or(0);
    let key = format!("joint '{name}': mimic");
    let (value, allowed) = match &way[begin..] {
        [_, _] => (
            "of itself".to_owned(),
            "name the joint that it follows, or remove mimic",
        ),
        circle => (
            format!("a circle {}", circle.join(" -> ")),
            "one joint of the circle has to move by itself; remove its mimic",
        ),
    };
    let place = Location::line(file, lines.of(&key));
    ModelError::value(place, key, value, allowed)
}

/// Couples `joints` according to `followed`: a joint that is followed gets the limits of
/// position and motion of its followers. `kinds` are the types in the file. Returns warnings.
pub(super) fn couple(
    (file, lines): (&str, &Lines),
    followed: &Followed<'_>,
    joints: &mut [Joint],
    limits: &mut [UrdfLimits],
    kinds: &[JointType],
) -> Vec<String> {
    let mut warnings = Vec::new();
    for index in 0..joints.len() {
        let Some(&(of, multiplier, offset)) = followed.get(joints[index].name.as_str()) else {
            continue;
        };
        let Some(joint) = joints.iter().position(|joint| joint.name == of) else {
            continue;
        };
        let mimic = Mimic {
            joint,
            multiplier,
            offset,
        };
        joints[index].mimic = Some(mimic);
        let range = (joints[joint].lower, joints[joint].upper);
        let own = before(&mimic, (joints[index].lower, joints[index].upper));
        let both = (range.0.max(own.0), range.1.min(own.1));
        let least = LEAST_RANGE * (range.1 - range.0).min(own.1 - own.0);
        if kinds[index] == JointType::Continuous {
            // A continuous joint has no limits.
        } else if both.1 - both.0 >= least {
            (joints[joint].lower, joints[joint].upper) = both;
        } else {
            let key = format!("joint '{}'", joints[index].name);
            let line = lines.of(&key).unwrap_or_default();
            warnings.push(format!(
                "{file}:{line}: {key}: its limits leave joint '{of}', which it copies, no range; \
                 those of '{of}' are taken"
            ));
        }
        slow(limits, index, &mimic);
    }
    // In a second pass: a followed joint has its final range only after all of its followers.
    for index in 0..joints.len() {
        if let Some(mimic) = joints[index].mimic {
            let followed = &joints[mimic.joint];
            let ends = [followed.lower, followed.upper].map(|end| mimic_at(&mimic, end));
            joints[index].lower = ends[0].min(ends[1]);
            joints[index].upper = ends[0].max(ends[1]);
        }
    }
    warnings
}

/// The positions of the followed joint at which its follower is in `range`.
fn before(mimic: &Mimic, range: (f64, f64)) -> (f64, f64) {
    let back = |end: f64| (end - mimic.offset) / mimic.multiplier;
    let (a, b) = (back(range.0), back(range.1));
    (a.min(b), a.max(b))
}

/// Limits the followed joint to the speed that the limits of joint `index` allow.
fn slow(limits: &mut [UrdfLimits], index: usize, mimic: &Mimic) {
    let per = mimic.multiplier.abs();
    let own = limits[index];
    let of = &mut limits[mimic.joint];
    let least = |one: Option<f64>, other: Option<f64>| match (one, other.map(|x| x / per)) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (one, other) => one.or(other),
    };
    let given = |value: f64| (value > 0.0).then_some(value);
    of.velocity = least(given(of.velocity), given(own.velocity)).unwrap_or(0.0);
    of.acceleration = least(of.acceleration, own.acceleration);
    of.jerk = least(of.jerk, own.jerk);
}

/// Position of the follower for a position of the followed joint (rad or m).
pub(crate) fn mimic_at(mimic: &Mimic, position: f64) -> f64 {
    mimic.multiplier * position + mimic.offset
}

/// Returns `joint`, which a file names as controlled, if it does not copy another one.
///
/// # Errors
/// Returns [`ModelError::Value`] at `place` if it does.
pub(super) fn controllable(
    chain: &rmp::Chain,
    joint: usize,
    place: Location,
    key: &str,
) -> Result<usize, ModelError> {
    let joints = chain.joints();
    let Some(mimic) = joints[joint].mimic else {
        return Ok(joint);
    };
    let allowed = format!(
        "it copies joint '{}' (mimic in the URDF), so only that one can be controlled",
        joints[mimic.joint].name
    );
    Err(ModelError::value(place, key, &joints[joint].name, allowed))
}

impl Robot {
    /// Followers of controlled joints: index in the chain, index of the controlled joint in the
    /// arm, and the coupling.
    pub fn followers(&self) -> impl Iterator<Item = (usize, usize, Mimic)> {
        let joints = self.chain.joints().iter().enumerate();
        joints.filter_map(|(index, joint)| {
            let mimic = joint.mimic?;
            let place = self.arm_joints.iter().position(|arm| *arm == mimic.joint)?;
            Some((index, place, mimic))
        })
    }

    /// Writes positions of the controlled joints, and of their followers, into positions of all
    /// joints of the chain (rad or m). Missing entries keep their values.
    pub fn place_arm(&self, arm: &[f64], all: &mut [f64]) {
        for (&index, position) in self.arm_joints.iter().zip(arm) {
            if let Some(slot) = all.get_mut(index) {
                *slot = *position;
            }
        }
        for (index, place, mimic) in self.followers() {
            if let (Some(slot), Some(position)) = (all.get_mut(index), arm.get(place)) {
                *slot = mimic_at(&mimic, *position);
            }
        }
    }

    /// Sets the home position of each follower to that of its followed joint.
    pub(crate) fn place_copies(&mut self) {
        for (index, joint) in self.chain.joints().iter().enumerate() {
            if let Some(mimic) = joint.mimic {
                self.joints[index].home = mimic_at(&mimic, self.joints[mimic.joint].home);
                self.fixed_joint_positions[index] =
                    mimic_at(&mimic, self.fixed_joint_positions[mimic.joint]);
            }
        }
    }
}
