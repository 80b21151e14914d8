//! Reads the part of COLLADA robot meshes are written in: triangles and
//! polygon lists, nodes with transforms, diffuse colours. Lights, cameras,
//! textures and animations are left out.

mod colour;
mod geometry;
mod transform;

use std::collections::{BTreeMap, HashMap};

use roxmltree::{Document, Node};

use crate::AssetError;
use crate::mesh::{ColourMesh, as_index};
use colour::Colours;
use geometry::Piece;
use transform::Transform;

/// How deep nodes may nest.
const DEPTH_LIMIT: usize = 32;

/// What a part of the reader says; the file is added at the top.
type Result<T> = std::result::Result<T, String>;

/// Reads a file; one mesh per colour, in the order of the colours, metres, Z up.
///
/// # Errors
///
/// When the text is not COLLADA, is not Z up, or refers to a missing element;
/// `file` is named in the error.
pub fn read(file: &str, text: &str) -> std::result::Result<Vec<ColourMesh>, AssetError> {
    read_up(file, text, Up::Z)
}

/// Which axes a file may say is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// Z alone.
    Z,
    /// Any, and it has no effect: so viewers of ROS read the meshes of a URDF, and their
    /// authors looked at them there.
    Ignored,
}

/// As [`read`], with a choice what to do about another axis.
///
/// # Errors
///
/// As for [`read`].
pub fn read_up(file: &str, text: &str, up: Up) -> std::result::Result<Vec<ColourMesh>, AssetError> {
    read_document(text, up).map_err(|reason| AssetError::Collada {
        file: file.to_owned(),
        reason,
    })
}

fn read_document(text: &str, up: Up) -> Result<Vec<ColourMesh>> {
    let document = Document::parse(text).map_err(|error| error.to_string())?;
    let root = document.root_element();
    if !root.has_tag_name_any("COLLADA") {
        return Err(format!(
            "root element is `{}`, not COLLADA",
            root.tag_name().name()
        ));
    }
    let mut reader = Reader {
        ids: root
            .descendants()
            .filter_map(|node| Some((node.attribute("id")?, node)))
            .collect(),
        geometries: HashMap::new(),
        meshes: BTreeMap::new(),
    };
    let unit = check_asset(root, up)?;
    let scene = reader.visual_scene(root)?;
    reader.children(scene, Transform::scaling(unit), 0)?;
    // By colour, not in the order of a hash map: the same file has to give the same bytes.
    Ok(reader.meshes.into_values().collect())
}

/// Metres of the file's unit.
fn check_asset(root: Node<'_, '_>, allowed: Up) -> Result<f64> {
    let asset = root.child("asset");
    let up = asset
        .and_then(|a| a.child("up_axis"))
        .and_then(|n| n.text());
    let other = up.map(str::trim).filter(|up| *up != "Z_UP");
    if let Some(up) = other.filter(|_| allowed == Up::Z) {
        return Err(format!("up_axis is {up}, allowed is Z_UP"));
    }
    let unit = asset
        .and_then(|a| a.child("unit"))
        .and_then(|n| n.attribute("meter"));
    let unit = unit.map_or(Ok(1.0), |text| {
        text.trim()
            .parse::<f64>()
            .map_err(|_| format!("unit meter=\"{text}\" is not a number"))
    })?;
    if unit.is_finite() && unit > 0.0 {
        Ok(unit)
    } else {
        Err(format!(
            "unit meter=\"{unit}\", allowed are numbers above 0"
        ))
    }
}

struct Reader<'a, 'input> {
    ids: HashMap<&'a str, Node<'a, 'input>>,
    /// Pieces of the geometries met so far, by id.
    geometries: HashMap<String, Vec<Piece>>,
    /// By colour, in steps of 1/255.
    meshes: BTreeMap<[u8; 3], ColourMesh>,
}

impl<'a, 'input> Reader<'a, 'input> {
    fn visual_scene(&self, root: Node<'a, 'input>) -> Result<Node<'a, 'input>> {
        let instance = root
            .child("scene")
            .and_then(|scene| scene.child("instance_visual_scene"))
            .ok_or("no scene/instance_visual_scene")?;
        self.target(instance, "url")
    }

    fn target(&self, node: Node<'a, 'input>, attribute: &str) -> Result<Node<'a, 'input>> {
        let line = geometry::line(node);
        let url = node
            .attribute(attribute)
            .ok_or_else(|| format!("line {line}: no {attribute}"))?;
        let id = url.strip_prefix('#').unwrap_or(url);
        let found = self.ids.get(id).copied();
        found.ok_or_else(|| format!("line {line}: nothing has the id `{id}`"))
    }

    fn children(&mut self, of: Node<'a, 'input>, at: Transform, depth: usize) -> Result<()> {
        // This function calls itself: a deeper file could overflow the stack, which ends the
        // process.
        if depth > DEPTH_LIMIT {
            return Err(format!("nodes nest deeper than {DEPTH_LIMIT}"));
        }
        for node in of.children().filter(Node::is_element) {
            match node.tag_name().name() {
                "node" => {
                    let own = at.then(&Transform::of_node(node)?);
                    self.children(node, own, depth + 1)?;
                }
                "instance_geometry" => self.instance(node, &at)?,
                // Without them parts of the mesh would be missing, and no message would say so.
                "instance_node" | "instance_controller" => {
                    let (name, line) = (node.tag_name().name(), geometry::line(node));
                    return Err(format!("line {line}: {name} is not supported"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn instance(&mut self, instance: Node<'a, 'input>, at: &Transform) -> Result<()> {
        let geometry = self.target(instance, "url")?;
        let id = geometry.attribute("id").unwrap_or_default().to_owned();
        if !self.geometries.contains_key(&id) {
            let pieces = geometry::pieces(geometry, &self.ids)?;
            self.geometries.insert(id.clone(), pieces);
        }
        let colours = Colours::of(instance);
        for piece in self.geometries.get(&id).into_iter().flatten() {
            let colour = colours.diffuse(&piece.material, &self.ids)?;
            let key = colour::key(colour);
            let mesh = self.meshes.entry(key).or_insert_with(|| ColourMesh {
                colour,
                ..ColourMesh::default()
            });
            append(mesh, piece, at);
        }
        Ok(())
    }
}

fn append(mesh: &mut ColourMesh, piece: &Piece, at: &Transform) {
    let base = as_index(mesh.positions.len());
    mesh.positions
        .extend(piece.positions.iter().map(|p| at.point(*p)));
    let mirrored = at.mirrors();
    mesh.triangles
        .extend(piece.triangles.iter().map(|[a, b, c]| {
            // A mirror turns triangles inside out.
            let [b, c] = if mirrored { [c, b] } else { [b, c] };
            [a + base, b + base, c + base]
        }));
}

/// Children by name, whatever the namespace: files of 1.4 and 1.5 differ in it.
trait Child<'a, 'input>: Sized {
    fn has_tag_name_any(&self, name: &str) -> bool;
    fn child(&self, name: &str) -> Option<Self>;
}

impl<'a, 'input> Child<'a, 'input> for Node<'a, 'input> {
    fn has_tag_name_any(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }

    fn child(&self, name: &str) -> Option<Self> {
        self.children().find(|node| node.has_tag_name_any(name))
    }
}

#[cfg(test)]
mod tests;
