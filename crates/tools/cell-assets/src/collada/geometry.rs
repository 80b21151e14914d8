//! Points and triangles of one geometry.

use std::collections::HashMap;

use roxmltree::Node;

use super::{Child, Result};
use crate::mesh::{Vec3, as_index};

/// Triangles of one material symbol, in the frame of the geometry.
pub(super) struct Piece {
    pub(super) material: String,
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Line of the file an element starts at.
pub(super) fn line(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// The finite numbers an element holds.
pub(super) fn numbers(node: Node<'_, '_>) -> Result<Vec<f64>> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    words
        .map(|word| match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(format!(
                "line {}: `{word}` is not a finite number",
                line(node)
            )),
        })
        .collect()
}

fn integers(node: Node<'_, '_>) -> Result<Vec<usize>> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    words
        .map(|word| {
            word.parse()
                .map_err(|_| format!("line {}: `{word}` is not an index", line(node)))
        })
        .collect()
}

/// Every piece of a geometry.
pub(super) fn pieces(
    geometry: Node<'_, '_>,
    ids: &HashMap<&str, Node<'_, '_>>,
) -> Result<Vec<Piece>> {
    let mesh = geometry
        .child("mesh")
        .ok_or_else(|| format!("line {}: geometry without mesh", line(geometry)))?;
    let mut pieces = Vec::new();
    for primitive in mesh.children().filter(Node::is_element) {
        match primitive.tag_name().name() {
            "triangles" | "polylist" => pieces.extend(piece(primitive, ids)?),
            // Without them the surface would have holes, and no message would say so.
            name @ ("polygons" | "tristrips" | "trifans") => {
                return Err(format!("line {}: {name} is not supported", line(primitive)));
            }
            // Lines and points have no surface.
            _ => {}
        }
    }
    Ok(pieces)
}

fn piece(primitive: Node<'_, '_>, ids: &HashMap<&str, Node<'_, '_>>) -> Result<Option<Piece>> {
    let Some(indices) = primitive.child("p") else {
        return Ok(None);
    };
    let (stride, offset, vertices) = layout(primitive)?;
    let positions = positions(vertices, ids)
        .ok_or_else(|| format!("line {}: no positions at `{vertices}`", line(primitive)))??;
    let all = integers(indices)?;
    let corners = all.chunks_exact(stride).filter_map(|c| c.get(offset));
    let corners: Vec<u32> = corners.map(|corner| as_index(*corner)).collect();
    // An index above 32 bits was saturated and is refused here as well.
    if let Some(far) = corners.iter().find(|c| **c as usize >= positions.len()) {
        let (line, count) = (line(indices), positions.len());
        return Err(format!("line {line}: point {far}, there are {count}"));
    }
    let triangles = match primitive.child("vcount") {
        Some(counts) => fans(&corners, &integers(counts)?)
            .ok_or_else(|| format!("line {}: more corners than points given", line(counts)))?,
        None => corners
            .chunks_exact(3)
            .map(|c| [c[0], c[1], c[2]])
            .collect(),
    };
    Ok(Some(Piece {
        material: primitive
            .attribute("material")
            .unwrap_or_default()
            .to_owned(),
        positions,
        triangles,
    }))
}

/// Indices per corner, place of the point among them, id of the vertices.
fn layout<'a>(primitive: Node<'a, '_>) -> Result<(usize, usize, &'a str)> {
    let mut stride = 0;
    let mut vertex = None;
    for input in primitive.children().filter(|n| n.has_tag_name_any("input")) {
        let text = input.attribute("offset").unwrap_or("0");
        // Of 8 bits, so that `offset + 1` below cannot overflow.
        let offset: u8 = text.parse().map_err(|_| {
            format!(
                "line {}: offset=\"{text}\", allowed are 0 to 255",
                line(input)
            )
        })?;
        let offset = usize::from(offset);
        stride = stride.max(offset + 1);
        if input.attribute("semantic") == Some("VERTEX") {
            vertex = input.attribute("source").map(|source| (offset, source));
        }
    }
    let (offset, source) =
        vertex.ok_or_else(|| format!("line {}: no input with semantic VERTEX", line(primitive)))?;
    Ok((stride, offset, source.trim_start_matches('#')))
}

fn positions(vertices: &str, ids: &HashMap<&str, Node<'_, '_>>) -> Option<Result<Vec<Vec3>>> {
    let input = ids
        .get(vertices)?
        .children()
        .find(|n| n.has_tag_name_any("input") && n.attribute("semantic") == Some("POSITION"))?;
    let source = ids.get(input.attribute("source")?.trim_start_matches('#'))?;
    let array = source.child("float_array")?;
    let accessor = source
        .descendants()
        .find(|n| n.has_tag_name_any("accessor"));
    let stride = accessor.and_then(|a| a.attribute("stride")).unwrap_or("3");
    if stride != "3" {
        let line = line(*source);
        return Some(Err(format!(
            "line {line}: stride {stride} of positions, allowed is 3"
        )));
    }
    let points = numbers(array);
    Some(points.map(|v| v.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()))
}

/// Polygons cut into triangles about their first corner; none when the counts
/// ask for more corners than there are.
fn fans(corners: &[u32], counts: &[usize]) -> Option<Vec<[u32; 3]>> {
    let mut rest = corners;
    let mut triangles = Vec::new();
    for count in counts {
        let polygon;
        (polygon, rest) = rest.split_at_checked(*count)?;
        let Some((first, others)) = polygon.split_first() else {
            continue;
        };
        triangles.extend(others.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    }
    Some(triangles)
}
