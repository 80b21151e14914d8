//! Checks of a robot that the URDF parser does not make.

use std::collections::{BTreeMap, BTreeSet};

use urdf_rs::{Geometry, Joint, JointType, Link, Robot};

use crate::error::{Location, ModelError};
use crate::robots::urdf_clean::Lines;
use crate::suggest;

/// Larger coordinates do not belong to a robot (m, rad).
pub(super) const MAX_COORDINATE: f64 = 100.0;
/// Largest number of links; a humanoid with two hands has some 80.
const MAX_LINKS: usize = 512;
/// A collision shape may be this long for any robot (m), plus twice the robot's length: a
/// longer one would be in contact with everything around it.
const LEAST_ROOM: f64 = 1.0;
/// Upper bound of masses (kg), inertias (kg·m²) and efforts (N·m) in a cell.
pub(super) const MAX_QUANTITY: f64 = 1.0e5;

/// Refuses a robot that is not one tree of uniquely named links with finite, plausible numbers.
///
/// # Errors
/// Returns [`ModelError::Value`] with file, link or joint, value and advice.
pub(crate) fn check(file: &str, lines: &Lines, robot: &Robot) -> Result<(), ModelError> {
    let checker = Checker { file, lines };
    // Counts first: the other checks compare names in pairs.
    checker.count(robot)?;
    checker.names(robot)?;
    checker.tree(robot)?;
    robot
        .joints
        .iter()
        .try_for_each(|joint| checker.joint(joint))?;
    let longest = LEAST_ROOM + 2.0 * length(robot);
    robot
        .links
        .iter()
        .try_for_each(|link| checker.link(link, longest))
}

/// Length of the stretched robot: the offsets of its joints, and the travel of the prismatic
/// ones (m).
fn length(robot: &Robot) -> f64 {
    let joints = robot.joints.iter().map(|joint| {
        let [x, y, z] = joint.origin.xyz.0;
        let travel = match joint.joint_type {
            JointType::Prismatic => joint.limit.upper - joint.limit.lower,
            _ => 0.0,
        };
        (x * x + y * y + z * z).sqrt() + travel
    });
    joints.sum()
}

struct Checker<'a> {
    file: &'a str,
    lines: &'a Lines,
}

impl Checker<'_> {
    fn refuse(
        &self,
        key: impl Into<String>,
        value: impl std::fmt::Display,
        allowed: impl Into<String>,
    ) -> ModelError {
        let key = key.into();
        let place = Location::line(self.file, self.lines.of(&key));
        ModelError::value(place, key, value, allowed)
    }

    fn count(&self, robot: &Robot) -> Result<(), ModelError> {
        let count = robot.links.len().max(robot.joints.len());
        if count <= MAX_LINKS {
            return Ok(());
        }
        let allowed =
            format!("at most {MAX_LINKS}; remove links that do not move and are not touched");
        Err(self.refuse("links and joints", count, allowed))
    }

    fn names(&self, robot: &Robot) -> Result<(), ModelError> {
        let links = robot.links.iter().map(|link| link.name.as_str());
        let joints = robot.joints.iter().map(|joint| joint.name.as_str());
        self.unique("link", links)?;
        self.unique("joint", joints)
    }

    fn unique<'b>(
        &self,
        what: &str,
        names: impl Iterator<Item = &'b str>,
    ) -> Result<(), ModelError> {
        let mut seen = BTreeSet::new();
        for name in names {
            if name.is_empty() {
                return Err(self.refuse(format!("name of a {what}"), "empty", "give it a name"));
            }
            if !seen.insert(name) {
                return Err(self.refuse(
                    format!("{what} '{name}'"),
                    "defined twice",
                    "rename one of them",
                ));
            }
        }
        Ok(())
    }

    /// Checks for one root from which every link is reached once.
    fn tree(&self, robot: &Robot) -> Result<(), ModelError> {
        let links: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
        let mut parent_joint: BTreeMap<&str, &str> = BTreeMap::new();
        for joint in &robot.joints {
            for end in [&joint.parent.link, &joint.child.link] {
                if !links.contains(&end.as_str()) {
                    let allowed = format!("no such link; {}", suggest::advice(end, &links));
                    return Err(self.refuse(
                        format!("joint '{}'", joint.name),
                        format!("attached to '{end}'"),
                        allowed,
                    ));
                }
            }
            if let Some(other) = parent_joint.insert(&joint.child.link, &joint.name) {
                let value = format!("the child of joints '{other}' and '{}'", joint.name);
                return Err(self.refuse(
                    format!("link '{}'", joint.child.link),
                    value,
                    "a link has one parent; loops cannot be loaded",
                ));
            }
        }
        let roots: Vec<&str> = links
            .iter()
            .copied()
            .filter(|link| !parent_joint.contains_key(link))
            .collect();
        match roots.as_slice() {
            // One root does not exclude a cycle beside its tree.
            [root] => self.reached(robot, root),
            [] => Err(self.refuse(
                "root link",
                "missing",
                "every link has a parent, so the joints form a cycle; remove one joint",
            )),
            _ => Err(self.refuse(
                "root link",
                format!("one of {}", roots.join(", ")),
                "join them by fixed joints or remove the loose ones",
            )),
        }
    }

    fn reached(&self, robot: &Robot, root: &str) -> Result<(), ModelError> {
        let mut children: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for joint in &robot.joints {
            children
                .entry(&joint.parent.link)
                .or_default()
                .push(&joint.child.link);
        }
        let mut open = vec![root];
        let mut reached = BTreeSet::new();
        while let Some(link) = open.pop() {
            reached.insert(link);
            open.extend(children.get(link).into_iter().flatten());
        }
        match robot
            .links
            .iter()
            .find(|link| !reached.contains(link.name.as_str()))
        {
            None => Ok(()),
            Some(link) => Err(self.refuse(
                format!("link '{}'", link.name),
                "part of a cycle",
                "remove one joint of the cycle",
            )),
        }
    }

    fn finite(&self, owner: &str, key: &str, values: &[f64], limit: f64) -> Result<(), ModelError> {
        // `contains` refuses NaN as well.
        match values
            .iter()
            .find(|value| !(-limit..=limit).contains(*value))
        {
            None => Ok(()),
            Some(value) => Err(self.refuse(
                format!("{owner}: {key}"),
                value,
                format!("a number from {} to {limit} is needed", -limit),
            )),
        }
    }

    fn link(&self, link: &Link, longest: f64) -> Result<(), ModelError> {
        let owner = format!("link '{}'", link.name);
        self.pose(&owner, "inertial origin", &link.inertial.origin)?;
        let mass = link.inertial.mass.value;
        if !(0.0..=MAX_QUANTITY).contains(&mass) {
            return Err(self.refuse(
                format!("{owner}: mass"),
                mass,
                format!("0 to {MAX_QUANTITY} kg is allowed"),
            ));
        }
        self.inertia(&owner, link)?;
        for collision in &link.collision {
            self.pose(&owner, "collision origin", &collision.origin)?;
            self.geometry(&owner, &collision.geometry, longest)?;
        }
        Ok(())
    }

    fn inertia(&self, owner: &str, link: &Link) -> Result<(), ModelError> {
        let i = &link.inertial.inertia;
        let key = "inertia";
        // Not whether it is positive: `urdf_clean` has replaced one that is not.
        self.finite(
            owner,
            key,
            &[i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz],
            MAX_QUANTITY,
        )
    }

    fn geometry(&self, owner: &str, geometry: &Geometry, longest: f64) -> Result<(), ModelError> {
        let lengths = match geometry {
            Geometry::Box { size } => size.to_vec(),
            Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
                vec![2.0 * *radius, *length]
            }
            Geometry::Sphere { radius } => vec![2.0 * *radius],
            Geometry::Mesh { .. } => vec![],
        };
        let fits = |length: &f64| (0.0..=longest).contains(length);
        match lengths.iter().find(|length| !fits(length)) {
            None => Ok(()),
            Some(length) => Err(self.refuse(
                format!("{owner}: collision size"),
                format!("{length} m"),
                format!("0 to {longest:.2} m is allowed, 1 m and twice the length of this robot"),
            )),
        }
    }

    fn pose(&self, owner: &str, key: &str, pose: &urdf_rs::Pose) -> Result<(), ModelError> {
        self.finite(owner, key, &pose.xyz.0, MAX_COORDINATE)?;
        self.finite(owner, key, &pose.rpy.0, MAX_COORDINATE)
    }

    fn joint(&self, joint: &Joint) -> Result<(), ModelError> {
        let owner = format!("joint '{}'", joint.name);
        self.pose(&owner, "origin", &joint.origin)?;
        self.finite(&owner, "axis", &joint.axis.xyz.0, MAX_COORDINATE)?;
        match joint.joint_type {
            JointType::Fixed => return Ok(()),
            JointType::Floating | JointType::Planar | JointType::Spherical => {
                let value = format!("{:?}", joint.joint_type).to_lowercase();
                return Err(self.refuse(
                    format!("{owner}: type"),
                    value,
                    "fixed, revolute, continuous and prismatic can be loaded",
                ));
            }
            JointType::Revolute | JointType::Continuous | JointType::Prismatic => {}
        }
        if joint.axis.xyz.iter().map(|x| x * x).sum::<f64>().sqrt() < 1.0e-9 {
            return Err(self.refuse(
                format!("{owner}: axis"),
                "zero",
                "a moving joint needs a direction",
            ));
        }
        self.limit(&owner, joint)
    }

    fn limit(&self, owner: &str, joint: &Joint) -> Result<(), ModelError> {
        let limit = &joint.limit;
        let continuous = joint.joint_type == JointType::Continuous;
        // 0 is allowed: it means no limit, and `plain_specs` takes a default.
        for (key, value) in [("effort", limit.effort), ("velocity", limit.velocity)] {
            if !(0.0..=MAX_QUANTITY).contains(&value) {
                return Err(self.refuse(
                    format!("{owner}: limit {key}"),
                    value,
                    format!("0 to {MAX_QUANTITY} is allowed"),
                ));
            }
        }
        // It has no ends, whichever limits the file gives.
        if continuous {
            return Ok(());
        }
        self.finite(owner, "limit lower", &[limit.lower], MAX_COORDINATE)?;
        self.finite(owner, "limit upper", &[limit.upper], MAX_COORDINATE)?;
        if limit.lower >= limit.upper {
            return Err(self.refuse(
                format!("{owner}: limit lower"),
                limit.lower,
                format!("it must be less than upper, {}", limit.upper),
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Lines, check};

    fn robot(shape: &str, links: usize) -> urdf_rs::Robot {
        let link = |index: usize| {
            format!(
                "<link name='l{index}'><collision><geometry>{shape}</geometry></collision></link>"
            )
        };
        let joint = |index: usize| {
            let parent = index - 1;
            format!(
                "<joint name='j{index}' type='fixed'><parent link='l{parent}'/>\
                 <child link='l{index}'/><origin xyz='0 0 0.5'/></joint>"
            )
        };
        let parts: String = (0..links).map(link).chain((1..links).map(joint)).collect();
        urdf_rs::read_from_string(&format!("<robot name='r'>{parts}</robot>")).unwrap()
    }

    #[test]
    fn a_shape_longer_than_the_robot_is_refused_with_its_link() {
        let refused = |shape: &str| {
            check("r.urdf", &Lines::default(), &robot(shape, 3))
                .unwrap_err()
                .to_string()
        };
        let said = refused("<capsule radius='0.1' length='17'/>");
        for part in ["link 'l0'", "17 m", "0 to 3.00 m"] {
            assert!(said.contains(part), "{said}");
        }
        assert!(refused("<sphere radius='1.6'/>").contains("3.2 m"));
        assert!(
            check(
                "r.urdf",
                &Lines::default(),
                &robot("<sphere radius='1.4'/>", 3)
            )
            .is_ok()
        );
    }

    #[test]
    fn a_robot_of_too_many_links_is_refused_at_once() {
        let said = check(
            "r.urdf",
            &Lines::default(),
            &robot("<sphere radius='0.1'/>", 513),
        )
        .unwrap_err();
        assert!(said.to_string().contains("513"), "{said}");
        assert!(
            check(
                "r.urdf",
                &Lines::default(),
                &robot("<sphere radius='0.1'/>", 512)
            )
            .is_ok()
        );
    }
}
