//! Elements, numbers and texts of a URDF.

use nalgebra::{Matrix3, SymmetricEigen};
use roxmltree::{Document, Node};

/// Largest number of undeclared prefixes of other formats in a URDF.
const MAX_PREFIXES: usize = 16;
/// Largest multiplier and offset of a joint that copies another one.
pub(super) const MAX_MIMIC: f64 = 100.0;

/// Blanks an XML declaration that is not at the start of the file, where the parser would
/// refuse it. Line numbers do not change.
pub(super) fn without_late_declaration(text: &str) -> String {
    match text.find("<?xml") {
        Some(at) if at > 0 => {
            let length = text[at..].find("?>").map_or(0, |end| end + 2);
            let blank = text[at..at + length].replace(|c| c != '\n', " ");
            format!("{}{blank}{}", &text[..at], &text[at + length..])
        }
        _ => text.to_owned(),
    }
}

/// Declares the prefixes that the parser would refuse.
pub(super) fn declare_prefixes(text: &str) -> String {
    let mut text = text.to_owned();
    for _ in 0..MAX_PREFIXES {
        // The parser names only the first prefix that it does not know.
        let Err(roxmltree::Error::UnknownNamespace(prefix, _)) = Document::parse(&text) else {
            break;
        };
        let Some(at) = root_name(&text).filter(|at| text[*at..].starts_with("robot")) else {
            break;
        };
        text.insert_str(at + "robot".len(), &format!(" xmlns:{prefix}=\"{prefix}\""));
    }
    text
}

/// Where the name of the outermost element starts: after comments and instructions, whose
/// text may look like an element.
fn root_name(text: &str) -> Option<usize> {
    let mut at = 0;
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        let end = if rest.starts_with("<!--") {
            "-->"
        } else if rest.starts_with("<?") {
            "?>"
        } else {
            return Some(at + 1);
        };
        at += rest.find(end)? + end.len();
    }
}

/// Elements of the URDF itself: those in the namespace of `owner`, which most files leave out.
/// Others belong to other formats.
pub(super) fn elements<'a, 'input>(
    owner: Node<'a, 'input>,
    tag: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    owner.children().filter(move |node| {
        let name = node.tag_name();
        node.is_element() && name.name() == tag && name.namespace() == owner.tag_name().namespace()
    })
}

pub(super) fn number(node: Node<'_, '_>, key: &str) -> Option<f64> {
    node.attribute(key)?.trim().parse().ok()
}

/// Three numbers; zeros if there is no such attribute. The error is the text that is not three
/// numbers.
pub(super) fn vector(node: Node<'_, '_>, key: &str) -> Result<Vec<f64>, String> {
    let Some(text) = node.attribute(key) else {
        return Ok(vec![0.0; 3]);
    };
    let parts = text.split(|c: char| c.is_whitespace() || c == ',');
    let parsed: Result<Vec<f64>, _> = parts
        .filter(|part| !part.is_empty())
        .map(str::parse)
        .collect();
    match parsed {
        Ok(values) if values.len() == 3 => Ok(values),
        _ => Err(text.to_owned()),
    }
}

/// A shape in the form of the parser; a mesh is a placeholder for one that is left out.
pub(super) fn shape_text(shape: Node<'_, '_>) -> Option<String> {
    // A missing length is 0, and the shape is left out with a warning by `is_without_volume`.
    let of = |key: &str| shape.attribute(key).unwrap_or("0").trim().parse::<f64>();
    match shape.tag_name().name() {
        "box" => Some(format!(
            "<box size=\"{}\"/>",
            text_of(&vector(shape, "size").ok()?)
        )),
        "sphere" => Some(format!("<sphere radius=\"{}\"/>", of("radius").ok()?)),
        tag @ ("cylinder" | "capsule") => {
            let (radius, length) = (of("radius").ok()?, of("length").ok()?);
            Some(format!("<{tag} radius=\"{radius}\" length=\"{length}\"/>"))
        }
        "mesh" => Some("<mesh filename=\"mesh\"/>".to_owned()),
        _ => None,
    }
}

/// Whether a shape has a length of 0, also one that is not given.
pub(super) fn is_without_volume(shape: Node<'_, '_>) -> bool {
    let keys: &[&str] = match shape.tag_name().name() {
        "box" => &["size"],
        "sphere" => &["radius"],
        "cylinder" | "capsule" => &["radius", "length"],
        _ => return false,
    };
    keys.iter().any(|key| {
        let text = shape.attribute(*key).unwrap_or("0");
        let mut numbers = text.split(|c: char| c.is_whitespace() || c == ',');
        numbers.any(|number| number.parse() == Ok(0.0))
    })
}

/// Smallest moment of inertia about an axis, as a share of the largest one.
const LEAST_MOMENT: f64 = 1.0e-6;

/// An inertia without an axis about which it is zero, as that of a rod without width: the
/// engine's inverse of such an inertia is not finite.
pub(super) fn with_moments(inertia: [f64; 6]) -> [f64; 6] {
    let matrix = matrix_of(&inertia);
    if !matrix.iter().all(|value| value.is_finite()) {
        return inertia;
    }
    let mut principal = SymmetricEigen::new(matrix);
    let least = LEAST_MOMENT * principal.eigenvalues.max();
    if principal.eigenvalues.min() >= least {
        return inertia;
    }
    principal.eigenvalues = principal.eigenvalues.map(|moment| moment.max(least));
    let m = principal.recompose();
    [
        m[(0, 0)],
        m[(0, 1)],
        m[(0, 2)],
        m[(1, 1)],
        m[(1, 2)],
        m[(2, 2)],
    ]
}

fn matrix_of([ixx, ixy, ixz, iyy, iyz, izz]: &[f64; 6]) -> Matrix3<f64> {
    Matrix3::new(*ixx, *ixy, *ixz, *ixy, *iyy, *iyz, *ixz, *iyz, *izz)
}

/// Whether an inertia is positive within rounding, by which identified inertias may miss it.
/// One that is not finite is refused later.
pub(super) fn is_positive(inertia: &[f64; 6]) -> bool {
    let matrix = matrix_of(inertia);
    if !matrix.iter().all(|value| value.is_finite()) {
        return true;
    }
    SymmetricEigen::new(matrix).eigenvalues.min() >= -1.0e-6 * matrix.norm()
}

pub(super) fn text_of(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    texts.join(" ")
}

pub(super) fn escaped(text: &str) -> String {
    // Attributes are written between double quotes, so `'` and `>` can stay.
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}
