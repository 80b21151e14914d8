//! Joints of a URDF: type, limits, and the joint that they copy.

use roxmltree::Node;

use super::limits::{self, Range};
use super::parts::{elements, number, text_of, vector};
use super::{Cleaner, parts};
use crate::error::{Location, ModelError};
use crate::suggest;

/// Types of joints that can be loaded.
const TYPES: [&str; 4] = ["revolute", "continuous", "prismatic", "fixed"];

impl Cleaner<'_, '_> {
    pub(super) fn joint(&mut self, joint: Node<'_, '_>) -> Result<(), ModelError> {
        let name = joint.attribute("name").unwrap_or_default();
        let line = self.line(joint);
        self.lines.joints.entry(name.to_owned()).or_insert(line);
        let stated = self.joint_type(joint, name)?;
        let limit = self.only(joint, "limit", name);
        let (kind, range) = self.range(joint, name, stated, limit)?;
        self.open("joint", &[("name", name), ("type", kind)]);
        if let Some(origin) = self.only(joint, "origin", name) {
            let xyz = self.joint_vector(origin, name, "xyz")?;
            let rpy = self.joint_vector(origin, name, "rpy")?;
            self.origin(&xyz, &rpy);
        }
        for end in ["parent", "child"] {
            let link = elements(joint, end)
                .next()
                .and_then(|node| node.attribute("link"));
            self.single(end, &[("link", link.unwrap_or_default())]);
        }
        if let Some(axis) = self.only(joint, "axis", name) {
            let xyz = if axis.has_attribute("xyz") {
                self.joint_vector(axis, name, "xyz")?
            } else {
                // The default of URDF.
                vec![1.0, 0.0, 0.0]
            };
            self.single("axis", &[("xyz", &text_of(&xyz))]);
        }
        let mimic = self.mimic(joint, name)?;
        let is_driven = mimic.is_none() && kind != "fixed";
        let velocity = self.rate(limit, name, (stated, "velocity"), is_driven)?;
        let effort = self.rate(limit, name, (stated, "effort"), is_driven)?;
        let mut attributes = vec![
            ("lower", range.lower.to_string()),
            ("upper", range.upper.to_string()),
            ("velocity", velocity.to_string()),
            ("effort", effort.to_string()),
        ];
        for key in ["acceleration", "jerk"] {
            let value = self.limit_number(limit, name, key)?;
            attributes.extend(value.map(|value| (key, value.to_string())));
        }
        self.numbers("limit", &attributes);
        if let Some((other, multiplier, offset)) = mimic {
            let (multiplier, offset) = (multiplier.to_string(), offset.to_string());
            self.single(
                "mimic",
                &[
                    ("joint", other),
                    ("multiplier", &multiplier),
                    ("offset", &offset),
                ],
            );
        }
        self.out.push_str("</joint>");
        if is_driven {
            self.soft_limits(joint, name, kind, range);
        }
        Ok(())
    }

    fn numbers(&mut self, tag: &str, attributes: &[(&str, String)]) {
        let attributes: Vec<(&str, &str)> = attributes
            .iter()
            .map(|(key, value)| (*key, value.as_str()))
            .collect();
        self.single(tag, &attributes);
    }

    fn refuse(
        &self,
        node: Node<'_, '_>,
        key: String,
        value: impl std::fmt::Display,
        allowed: impl Into<String>,
    ) -> ModelError {
        let place = Location::line(self.file, Some(self.line(node)));
        ModelError::value(place, key, value, allowed)
    }

    /// Its type, which has to be one of [`TYPES`]: the meaning of another one is not guessed.
    fn joint_type<'b>(&self, joint: Node<'b, '_>, name: &str) -> Result<&'b str, ModelError> {
        let key = format!("joint '{name}': type");
        let advice = match joint.attribute("type") {
            Some(stated) if TYPES.contains(&stated) => return Ok(stated),
            Some("floating" | "planar") => {
                "a robot has a fixed base and joints of one axis: make it fixed, or make it \
                 of prismatic and revolute joints"
            }
            Some("spherical" | "ball") => "make it of three revolute joints, or fixed",
            Some("screw") => {
                "make it prismatic or revolute, whichever of its motions matters, or fixed"
            }
            Some(other) => {
                let advice = suggest::advice(other, &TYPES);
                return Err(self.refuse(joint, key, format!("'{other}'"), advice));
            }
            None => {
                let allowed = format!("one of {} is needed", TYPES.join(", "));
                return Err(self.refuse(joint, key, "missing", allowed));
            }
        };
        let stated = joint.attribute("type").unwrap_or_default();
        let allowed = format!("{} can be loaded; {advice}", TYPES.join(", "));
        Err(self.refuse(joint, key, stated, allowed))
    }

    /// The number of an attribute of a limit; `None` if there is no such attribute.
    fn limit_number(
        &self,
        limit: Option<Node<'_, '_>>,
        name: &str,
        key: &str,
    ) -> Result<Option<f64>, ModelError> {
        let Some((node, text)) = limit.and_then(|node| Some((node, node.attribute(key)?))) else {
            return Ok(None);
        };
        text.trim().parse().map(Some).map_err(|_| {
            let key = format!("joint '{name}': limit {key}");
            self.refuse(node, key, format!("\"{text}\""), "a number is needed")
        })
    }

    /// Type and limits of a joint as they are used.
    fn range<'b>(
        &mut self,
        joint: Node<'_, '_>,
        name: &str,
        stated: &'b str,
        limit: Option<Node<'_, '_>>,
    ) -> Result<(&'b str, Range), ModelError> {
        if !["revolute", "prismatic"].contains(&stated) {
            return Ok((stated, Range::NONE));
        }
        let number = |key: &str| self.limit_number(limit, name, key);
        let stated_range = Range {
            lower: number("lower")?.unwrap_or(0.0),
            upper: number("upper")?.unwrap_or(0.0),
        };
        let slides = stated == "prismatic";
        let taken = limits::taken(stated_range, slides, self.in_degrees);
        if let Some(what) = taken.warning {
            self.notice(joint, format!("'{name}'"), what);
        }
        let kind = if taken.turns_on { "continuous" } else { stated };
        Ok((kind, taken.range))
    }

    /// Limit of velocity or effort; 0 means none.
    fn rate(
        &mut self,
        limit: Option<Node<'_, '_>>,
        name: &str,
        (stated, key): (&str, &str),
        is_driven: bool,
    ) -> Result<f64, ModelError> {
        let Some(value) = self.limit_number(limit, name, key)? else {
            return Ok(0.0);
        };
        let slides = stated == "prismatic";
        let (taken, warning) = limits::rate_taken(value, key, slides, self.in_degrees);
        if let (Some(what), Some(node), true) = (warning, limit, is_driven) {
            self.notice(node, format!("'{name}'"), what);
        }
        Ok(taken)
    }

    /// Reports the soft limits of a joint if they are within its limits.
    fn soft_limits(&mut self, joint: Node<'_, '_>, name: &str, kind: &str, range: Range) {
        let Some(safety) = elements(joint, "safety_controller").next() else {
            return;
        };
        let soft = |key: &str| number(safety, key).unwrap_or(0.0);
        let soft = Range {
            lower: soft("soft_lower_limit"),
            upper: soft("soft_upper_limit"),
        };
        let is_within = kind == "continuous" || soft.is_within(range);
        if is_within && soft.lower < soft.upper {
            let joint_text = format!("'{name}' ({} to {})", soft.lower, soft.upper);
            let what = "soft limits of safety_controller are not applied, those of limit are";
            self.notice(safety, joint_text, what.to_owned());
        }
    }

    /// The copied joint, with multiplier and offset.
    fn mimic<'b>(
        &mut self,
        joint: Node<'b, '_>,
        name: &str,
    ) -> Result<Option<(&'b str, f64, f64)>, ModelError> {
        let Some(mimic) = elements(joint, "mimic").next() else {
            return Ok(None);
        };
        let other = mimic.attribute("joint").unwrap_or_default();
        let reason = match self.joints.get(other).map(String::as_str) {
            None => "which does not exist",
            Some("fixed") => "which does not move",
            Some(_) => {
                let multiplier = self.mimic_number(mimic, name, ("multiplier", 1.0))?;
                let offset = self.mimic_number(mimic, name, ("offset", 0.0))?;
                return Ok(Some((other, multiplier, offset)));
            }
        };
        // Ignored with a warning: the joint then moves on its own, as the rest of the file
        // describes it.
        self.warn(
            mimic,
            format_args!("joint '{name}': mimic of joint '{other}', {reason}, is ignored"),
        );
        Ok(None)
    }

    fn mimic_number(
        &self,
        mimic: Node<'_, '_>,
        name: &str,
        (key, default): (&str, f64),
    ) -> Result<f64, ModelError> {
        let Some(text) = mimic.attribute(key) else {
            return Ok(default);
        };
        let most = parts::MAX_MIMIC;
        let is_allowed = |value: &f64| match key {
            // Not 0: the limits of the followed joint are those of its follower divided by it.
            "multiplier" => (1.0 / most..=most).contains(&value.abs()),
            _ => (-most..=most).contains(value),
        };
        let allowed = match key {
            "multiplier" => format!("{} to {most}, or the negative, is needed", 1.0 / most),
            _ => format!("{} to {most} is needed", -most),
        };
        let value = text.trim().parse().ok().filter(is_allowed);
        value.ok_or_else(|| {
            let key = format!("joint '{name}': mimic {key}");
            self.refuse(mimic, key, format!("\"{text}\""), allowed)
        })
    }

    /// Numbers that decide the robot's kinematics: an unreadable one is an error, not a
    /// default.
    fn joint_vector(
        &self,
        node: Node<'_, '_>,
        joint: &str,
        key: &str,
    ) -> Result<Vec<f64>, ModelError> {
        vector(node, key).map_err(|found| {
            let key = format!("joint '{joint}': {} {key}", node.tag_name().name());
            let allowed = "three numbers with spaces between them are needed";
            self.refuse(node, key, format!("\"{found}\""), allowed)
        })
    }

    fn notice(&mut self, node: Node<'_, '_>, joint: String, what: String) {
        let line = self.line(node);
        self.notices.add(line, joint, what);
    }
}
