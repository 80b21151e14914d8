//! The collision geometry of a URDF, by link, as triangles in the frame of the link.

use std::path::Path;

use cell_model::user_file;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder};
use roxmltree::{Document, Node};

use crate::spheres::error::SphereError;
use crate::spheres::place::Packages;
use crate::spheres::surface::Surface;
use crate::spheres::{mesh, name_of};

/// Corners around a round primitive.
const ROUND: u32 = 24;
/// Largest coordinate of a link (m): larger geometry is in another unit.
const MAX_EXTENT_M: f64 = 20.0;
/// Geometry smaller than this in all directions is a point, not a part of a link (m).
const MIN_EXTENT_M: f64 = 1.0e-4;

/// One link with geometry.
pub(crate) struct LinkSurface {
    pub(crate) name: String,
    pub(crate) surface: Surface,
    pub(crate) is_visual: bool,
}

/// Reads the geometry of all links of the URDF at `path`, which the reader of robots
/// accepts.
pub(crate) fn read(path: &Path, packages: &Packages) -> Result<Vec<LinkSurface>, SphereError> {
    let file = name_of(path);
    let fail = |reason: String| SphereError::Read {
        file: file.clone(),
        reason,
    };
    let text = user_file::read_text(path).map_err(|error| fail(error.to_string()))?;
    let document = Document::parse(&text).map_err(|error| fail(error.to_string()))?;
    let mut links = Vec::new();
    for link in children(document.root_element(), "link") {
        let reader = Reader {
            path,
            file: &file,
            packages,
            document: &document,
            link: link.attribute("name").unwrap_or_default(),
        };
        links.extend(reader.link(link)?);
    }
    if links.is_empty() {
        return Err(SphereError::Empty { file });
    }
    Ok(links)
}

/// Elements by name, whatever their namespace.
fn children<'a, 'i>(of: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    of.children()
        .filter(move |node| node.is_element() && node.tag_name().name() == name)
}

/// The shape of a collision or visual element.
fn shape_of<'a, 'i>(part: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    let geometry = children(part, "geometry").next()?;
    geometry.children().find(Node::is_element)
}

struct Reader<'a, 'i> {
    path: &'a Path,
    file: &'a str,
    packages: &'a Packages,
    document: &'a Document<'i>,
    link: &'a str,
}

impl Reader<'_, '_> {
    fn link(&self, link: Node<'_, '_>) -> Result<Option<LinkSurface>, SphereError> {
        let has_collision = children(link, "collision").any(|part| shape_of(part).is_some());
        let kind = if has_collision { "collision" } else { "visual" };
        let mut surface = Surface::default();
        for part in children(link, kind) {
            if let Some(shape) = shape_of(part) {
                self.add(&mut surface, part, shape)?;
            }
        }
        let named = LinkSurface {
            name: self.link.to_owned(),
            surface,
            is_visual: !has_collision,
        };
        Ok((!named.surface.triangles.is_empty()).then_some(named))
    }

    fn add(
        &self,
        surface: &mut Surface,
        part: Node<'_, '_>,
        shape: Node<'_, '_>,
    ) -> Result<(), SphereError> {
        let origin = children(part, "origin").next();
        let vector = |key: &str| {
            origin.map_or(Ok(Vector3::zeros()), |node| {
                self.vector(node, key, Vector3::zeros())
            })
        };
        let (xyz, rpy) = (vector("xyz")?, vector("rpy")?);
        let pose = Isometry3::from_parts(
            Translation3::from(xyz),
            UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z),
        );
        let (own, scale) = match shape.tag_name().name() {
            "mesh" => {
                let scale = self.scale(shape)?;
                (self.mesh(shape)?, scale)
            }
            _ => (self.primitive(shape)?, Vector3::repeat(1.0)),
        };
        let extent = own.extent().component_mul(&scale).amax();
        if extent < MIN_EXTENT_M {
            return Err(self.refuse(
                shape,
                format!(
                    "its longest side has {extent:.1e} m; at least {MIN_EXTENT_M} m are needed: correct its size or its scale"
                ),
            ));
        }
        surface.add(&own, &pose, &scale);
        let far = surface.points.iter().map(|p| p.coords.amax());
        let far = far.fold(0.0, f64::max);
        if far > MAX_EXTENT_M {
            return Err(self.refuse(
                shape,
                format!(
                    "its geometry reaches {far:.0} m; at most {MAX_EXTENT_M} m are allowed: a mesh in millimetres needs scale=\"0.001 0.001 0.001\""
                ),
            ));
        }
        Ok(())
    }

    /// The scale of a mesh; a negative number mirrors it.
    fn scale(&self, shape: Node<'_, '_>) -> Result<Vector3<f64>, SphereError> {
        let scale = self.vector(shape, "scale", Vector3::repeat(1.0))?;
        if scale.iter().all(|factor| *factor != 0.0) {
            return Ok(scale);
        }
        let text = shape.attribute("scale").unwrap_or_default();
        let allowed = "numbers other than 0 are needed: 0.001 0.001 0.001 for a mesh in millimetres, or no scale for one in metres";
        Err(self.refuse(shape, format!("scale=\"{text}\": {allowed}")))
    }

    fn mesh(&self, shape: Node<'_, '_>) -> Result<Surface, SphereError> {
        let uri = shape.attribute("filename").unwrap_or_default();
        let path = self.packages.find(self.path, uri).map_err(|tried| {
            let tried: Vec<String> = tried.iter().map(|path| name_of(path)).collect();
            SphereError::Missing {
                file: self.file.to_owned(),
                line: self.line(shape),
                link: self.link.to_owned(),
                uri: uri.to_owned(),
                looked: tried.join(", "),
            }
        })?;
        mesh::read(&path)
            .map_err(|reason| self.refuse(shape, format!("mesh {}: {reason}", name_of(&path))))
    }

    fn primitive(&self, shape: Node<'_, '_>) -> Result<Surface, SphereError> {
        let length = |key: &str| -> Result<f64, SphereError> {
            let text = shape.attribute(key).unwrap_or_default();
            let length = self.number(shape, key, text)?;
            self.positive(shape, key, &[length])?;
            Ok(length)
        };
        let (points, triangles) = match shape.tag_name().name() {
            "box" => {
                let size = self.vector(shape, "size", Vector3::zeros())?;
                self.positive(shape, "size", size.as_slice())?;
                Cuboid::new(parry3d_f64::math::Vector::new(
                    0.5 * size.x,
                    0.5 * size.y,
                    0.5 * size.z,
                ))
                .to_trimesh()
            }
            "sphere" => Ball::new(length("radius")?).to_trimesh(ROUND, ROUND),
            "cylinder" => {
                Cylinder::new(0.5 * length("length")?, length("radius")?).to_trimesh(ROUND)
            }
            "capsule" => {
                let (half, radius) = (0.5 * length("length")?, length("radius")?);
                Capsule::new_y(half, radius).to_trimesh(ROUND, ROUND)
            }
            other => {
                let allowed = "box, sphere, cylinder, capsule and mesh are allowed";
                return Err(self.refuse(shape, format!("geometry <{other}>: {allowed}")));
            }
        };
        // Round shapes of URDF are along z, those of parry along y.
        let is_round = !matches!(shape.tag_name().name(), "box" | "sphere");
        let turn = if is_round {
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2)
        } else {
            UnitQuaternion::identity()
        };
        let points = points.iter();
        Ok(Surface {
            points: points.map(|p| turn * Point3::new(p.x, p.y, p.z)).collect(),
            triangles,
        })
    }

    fn vector(
        &self,
        node: Node<'_, '_>,
        key: &str,
        default: Vector3<f64>,
    ) -> Result<Vector3<f64>, SphereError> {
        let Some(text) = node.attribute(key) else {
            return Ok(default);
        };
        let numbers = text.split_whitespace();
        let numbers: Vec<f64> = numbers
            .map(|word| self.number(node, key, word))
            .collect::<Result<_, _>>()?;
        match numbers[..] {
            [x, y, z] => Ok(Vector3::new(x, y, z)),
            _ => Err(self.refuse(node, format!("{key}=\"{text}\": three numbers are needed"))),
        }
    }

    fn number(&self, node: Node<'_, '_>, key: &str, text: &str) -> Result<f64, SphereError> {
        // NaN and infinity, which `parse` accepts, fail the comparison.
        let number = text.trim().parse().ok().filter(|x: &f64| x.abs() < 1e6);
        number.ok_or_else(|| self.refuse(node, format!("{key}=\"{text}\": a number is needed")))
    }

    fn positive(&self, node: Node<'_, '_>, key: &str, lengths: &[f64]) -> Result<(), SphereError> {
        if lengths.iter().all(|length| *length > 0.0) {
            return Ok(());
        }
        let text = node.attribute(key).unwrap_or_default();
        Err(self.refuse(
            node,
            format!("{key}=\"{text}\": lengths above 0 m are needed"),
        ))
    }

    fn line(&self, node: Node<'_, '_>) -> u32 {
        self.document.text_pos_at(node.range().start).row
    }

    fn refuse(&self, node: Node<'_, '_>, reason: String) -> SphereError {
        SphereError::Geometry {
            file: self.file.to_owned(),
            line: self.line(node),
            link: self.link.to_owned(),
            reason,
        }
    }
}
