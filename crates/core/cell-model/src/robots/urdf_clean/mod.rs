//! Prepares a URDF for its parser: keeps the description of the robot, and drops visuals and
//! the elements of other programs. Faults with one possible meaning are corrected and become
//! warnings with their line; the others are refused later, with the same lines.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use roxmltree::{Document, Node};

mod joints;
mod limits;
mod notices;
mod parts;
mod xacro;

use notices::Notices;
use parts::{
    elements, escaped, is_positive, is_without_volume, number, shape_text, text_of, vector,
};

use crate::error::{Location, ModelError};

/// Radius of the ball whose inertia a link without inertia gets (m).
const BALL_M: f64 = 0.05;

/// A cleaned file.
pub(super) struct Cleaned {
    /// The URDF.
    pub(super) text: String,
    /// Corrected faults, with file and line.
    pub(super) warnings: Vec<String>,
    /// Lines of links and joints.
    pub(super) lines: Lines,
}

/// Lines of links and joints by name.
#[derive(Default)]
pub(super) struct Lines {
    links: BTreeMap<String, usize>,
    joints: BTreeMap<String, usize>,
}

impl Lines {
    /// The line of the subject of a message: `link 'NAME': ..` or `joint 'NAME': ..`.
    pub(super) fn of(&self, key: &str) -> Option<usize> {
        let named = |word: &str, lines: &BTreeMap<String, usize>| {
            let rest = key.strip_prefix(word)?.strip_prefix(" '")?;
            lines.get(rest.split('\'').next()?).copied()
        };
        named("link", &self.links).or_else(|| named("joint", &self.joints))
    }
}

/// Reads and cleans a URDF; `file` is its name in messages.
///
/// # Errors
/// Returns [`ModelError`] for text that is not XML, for a xacro file, and for joints whose type
/// or numbers cannot be used.
pub(super) fn clean(file: &str, text: &str) -> Result<Cleaned, ModelError> {
    let declared = parts::declare_prefixes(&parts::without_late_declaration(text));
    let document = Document::parse(&declared).map_err(|error| ModelError::Syntax {
        place: Location::line(file, usize::try_from(error.pos().row).ok()),
        message: format!("no XML: {error}"),
    })?;
    xacro::refuse(file, &document)?;
    let mut cleaner = Cleaner {
        file,
        document: &document,
        out: String::new(),
        warnings: Vec::new(),
        lines: Lines::default(),
        joints: BTreeMap::new(),
        in_degrees: false,
        notices: Notices::default(),
    };
    cleaner.robot(document.root_element())?;
    cleaner.warnings.extend(cleaner.notices.lines(file));
    Ok(Cleaned {
        text: cleaner.out,
        warnings: cleaner.warnings,
        lines: cleaner.lines,
    })
}

struct Cleaner<'a, 'input> {
    file: &'a str,
    document: &'a Document<'input>,
    out: String,
    warnings: Vec<String>,
    lines: Lines,
    /// Types of all joints, by name.
    joints: BTreeMap<String, String>,
    /// Whether limits of revolute joints are in degrees.
    in_degrees: bool,
    notices: Notices,
}

impl Cleaner<'_, '_> {
    fn line(&self, node: Node<'_, '_>) -> usize {
        let at = self.document.text_pos_at(node.range().start);
        usize::try_from(at.row).unwrap_or(0)
    }

    fn warn(&mut self, node: Node<'_, '_>, what: impl std::fmt::Display) {
        let line = self.line(node);
        self.warnings.push(format!("{}:{line}: {what}", self.file));
    }

    fn robot(&mut self, root: Node<'_, '_>) -> Result<(), ModelError> {
        if root.tag_name().name() != "robot" {
            return Err(ModelError::Syntax {
                place: Location::line(self.file, Some(self.line(root))),
                message: format!(
                    "no URDF: the outermost element is '{}', not 'robot'",
                    root.tag_name().name()
                ),
            });
        }
        self.open(
            "robot",
            &[("name", root.attribute("name").unwrap_or("robot"))],
        );
        // Types of all joints first: `mimic` may name a joint that follows in the file.
        for joint in elements(root, "joint") {
            let of = |key: &str| joint.attribute(key).unwrap_or_default().to_owned();
            self.joints.insert(of("name"), of("type"));
        }
        // Decided for the whole file: one large limit alone may mean no limit.
        self.in_degrees = limits::in_degrees(root);
        for link in elements(root, "link") {
            self.link(link);
        }
        for joint in elements(root, "joint") {
            self.joint(joint)?;
        }
        self.out.push_str("</robot>");
        Ok(())
    }

    fn link(&mut self, link: Node<'_, '_>) {
        let name = link.attribute("name").unwrap_or_default();
        let line = self.line(link);
        self.lines.links.entry(name.to_owned()).or_insert(line);
        self.open("link", &[("name", name)]);
        if let Some(inertial) = self.only(link, "inertial", name) {
            self.inertial(inertial, name);
        }
        for collision in elements(link, "collision") {
            self.collision(collision, name);
        }
        self.out.push_str("</link>");
    }

    fn inertial(&mut self, inertial: Node<'_, '_>, link: &str) {
        self.out.push_str("<inertial>");
        if let Some(origin) = self.only(inertial, "origin", link) {
            match (vector(origin, "xyz"), vector(origin, "rpy")) {
                (Ok(xyz), Ok(rpy)) => self.origin(&xyz, &rpy),
                _ => self.warn(
                    origin,
                    format_args!(
                        "link '{link}': the centre of mass is unreadable; its origin is taken"
                    ),
                ),
            }
        }
        let value = |tag: &'static str, key: &str| {
            let found = elements(inertial, tag).next();
            found.and_then(|node| number(node, key)).unwrap_or(0.0)
        };
        let mass = value("mass", "value");
        let keys = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        let mut inertia = keys.map(|key| value("inertia", key));
        if !is_positive(&inertia) {
            // A negative mass is refused later, with its number.
            let ball = 0.4 * mass.max(0.0) * BALL_M * BALL_M;
            self.warn(
                inertial,
                format_args!(
                    "link '{link}': the inertia is not positive; that of a ball of {BALL_M} m is taken"
                ),
            );
            inertia = [ball, 0.0, 0.0, ball, 0.0, ball];
        }
        let inertia = parts::with_moments(inertia);
        self.single("mass", &[("value", &mass.to_string())]);
        let texts = inertia.map(|value| value.to_string());
        let attributes: Vec<(&str, &str)> = keys
            .into_iter()
            .zip(texts.iter().map(String::as_str))
            .collect();
        self.single("inertia", &attributes);
        self.out.push_str("</inertial>");
    }

    /// Copies a shape; one that cannot be read is left out with a warning.
    fn collision(&mut self, collision: Node<'_, '_>, link: &str) {
        let geometry = elements(collision, "geometry").next();
        let Some(shape) = geometry.and_then(|node| node.children().find(Node::is_element)) else {
            return;
        };
        let origin = elements(collision, "origin").next();
        let read = |key: &str| origin.map_or(Ok(vec![0.0; 3]), |node| vector(node, key));
        let (Ok(xyz), Ok(rpy), Some(shape_text)) = (read("xyz"), read("rpy"), shape_text(shape))
        else {
            self.warn(
                collision,
                format_args!("link '{link}': a collision shape is unreadable and left out"),
            );
            return;
        };
        if is_without_volume(shape) {
            self.warn(
                shape,
                format_args!("link '{link}': a collision shape with a length of 0 is left out"),
            );
            return;
        }
        self.out.push_str("<collision>");
        self.origin(&xyz, &rpy);
        let _infallible = write!(self.out, "<geometry>{shape_text}</geometry></collision>");
    }

    /// The element with that name; of several the first, with a warning.
    fn only<'b, 'input>(
        &mut self,
        owner: Node<'b, 'input>,
        tag: &'static str,
        name: &str,
    ) -> Option<Node<'b, 'input>> {
        let mut found = elements(owner, tag);
        let first = found.next();
        if let Some(second) = found.next() {
            self.warn(
                second,
                format_args!("'{name}' has a second {tag}, which is ignored"),
            );
        }
        first
    }

    fn open(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.out.push('>');
    }

    fn single(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.out.push_str("/>");
    }

    fn start(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        let _infallible = write!(self.out, "<{tag}");
        for (key, value) in attributes {
            let _infallible = write!(self.out, " {key}=\"{}\"", escaped(value));
        }
    }

    fn origin(&mut self, xyz: &[f64], rpy: &[f64]) {
        self.single("origin", &[("xyz", &text_of(xyz)), ("rpy", &text_of(rpy))]);
    }
}
