//! Binary glTF 2.0, written by hand: one mesh, one primitive per colour.
//!
//! Points stay as they are (Z up, metres, frame of the link): the reader puts
//! the file under its link without another turn.

use serde_json::{Value, json};

use crate::AssetError;
use crate::normals::ShadedMesh;

const MAGIC: u32 = 0x4654_6C67;
const VERSION: u32 = 2;
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;
const TYPE_U16: u32 = 5123;
const TYPE_U32: u32 = 5125;
const TYPE_F32: u32 = 5126;
const TARGET_VERTICES: u32 = 34962;
const TARGET_INDICES: u32 = 34963;

/// Painted plastic.
const ROUGHNESS: f32 = 0.55;

/// One sRGB channel made linear (IEC 61966-2-1): glTF factors are linear.
pub fn linear(srgb: f32) -> f32 {
    if srgb <= 0.040_45 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

/// Writes a file with `meshes` under one node called `name`.
///
/// # Errors
///
/// When the file would have 4 GiB or more.
pub fn write(name: &str, meshes: &[ShadedMesh]) -> Result<Vec<u8>, AssetError> {
    let mut parts = Parts::default();
    // glTF does not allow an accessor without elements.
    let meshes: Vec<&ShadedMesh> = meshes.iter().filter(|m| !m.indices.is_empty()).collect();
    let primitives: Vec<Value> = meshes.iter().map(|mesh| parts.primitive(mesh)).collect();
    let root = json!({
        "asset": { "version": "2.0", "generator": "robocell" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": name, "mesh": 0 }],
        "meshes": [{ "name": name, "primitives": primitives }],
        "materials": parts.materials,
        "accessors": parts.accessors,
        "bufferViews": parts.views,
        "buffers": [{ "byteLength": parts.bin.len() }],
    });
    let mut text = root.to_string().into_bytes();
    // glTF requires chunks of whole words, and pads JSON with spaces.
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + parts.bin.len();
    let size = |len: usize| u32::try_from(len).map_err(|_| AssetError::TooLarge(total));
    let mut file = Vec::with_capacity(total);
    for word in [MAGIC, VERSION, size(total)?, size(text.len())?, CHUNK_JSON] {
        file.extend(word.to_le_bytes());
    }
    file.extend(&text);
    for word in [size(parts.bin.len())?, CHUNK_BIN] {
        file.extend(word.to_le_bytes());
    }
    file.extend(&parts.bin);
    Ok(file)
}

#[derive(Default)]
struct Parts {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
}

impl Parts {
    fn primitive(&mut self, mesh: &ShadedMesh) -> Value {
        let [r, g, b] = mesh.colour.map(linear);
        self.materials.push(json!({
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": ROUGHNESS,
            },
        }));
        let material = self.materials.len() - 1;
        // glTF requires bounds of positions, and of no other attribute.
        let position = self.vectors(&mesh.positions, true);
        let normal = self.vectors(&mesh.normals, false);
        let indices = self.indices(mesh);
        json!({
            "attributes": { "POSITION": position, "NORMAL": normal },
            "indices": indices,
            "material": material,
        })
    }

    fn vectors(&mut self, vectors: &[[f32; 3]], bounds: bool) -> usize {
        let bytes = vectors.as_flattened().iter().flat_map(|c| c.to_le_bytes());
        let view = self.view(bytes.collect(), TARGET_VERTICES);
        let mut accessor = json!({
            "bufferView": view,
            "componentType": TYPE_F32,
            "count": vectors.len(),
            "type": "VEC3",
        });
        if bounds {
            let fold = |start: f32, by: fn(f32, f32) -> f32| {
                vectors
                    .iter()
                    .fold([start; 3], |a, v| [0, 1, 2].map(|i| by(a[i], v[i])))
            };
            accessor["min"] = json!(fold(f32::INFINITY, f32::min));
            accessor["max"] = json!(fold(f32::NEG_INFINITY, f32::max));
        }
        self.accessor(accessor)
    }

    fn indices(&mut self, mesh: &ShadedMesh) -> usize {
        // The largest value of the type is reserved.
        let small: Option<Vec<u16>> = (mesh.positions.len() < usize::from(u16::MAX))
            .then(|| {
                mesh.indices
                    .iter()
                    .map(|i| u16::try_from(*i).ok())
                    .collect()
            })
            .flatten();
        let (bytes, kind) = match small {
            Some(small) => (
                small.iter().flat_map(|i| i.to_le_bytes()).collect(),
                TYPE_U16,
            ),
            None => (
                mesh.indices.iter().flat_map(|i| i.to_le_bytes()).collect(),
                TYPE_U32,
            ),
        };
        let view = self.view(bytes, TARGET_INDICES);
        self.accessor(json!({
            "bufferView": view,
            "componentType": kind,
            "count": mesh.indices.len(),
            "type": "SCALAR",
        }))
    }

    fn view(&mut self, bytes: Vec<u8>, target: u32) -> usize {
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": self.bin.len(),
            "byteLength": bytes.len(),
            "target": target,
        }));
        self.bin.extend(bytes);
        // The next view may hold words, which have to be aligned.
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    fn word(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    fn number(value: &Value) -> usize {
        usize::try_from(value.as_u64().unwrap()).unwrap()
    }

    /// Reads a file back; colours as they would be on a screen.
    pub(crate) fn parse(bytes: &[u8]) -> Vec<ShadedMesh> {
        assert_eq!(word(bytes, 0), MAGIC);
        assert_eq!(word(bytes, 8) as usize, bytes.len());
        let text_len = word(bytes, 12) as usize;
        let root: Value = serde_json::from_slice(&bytes[20..20 + text_len]).unwrap();
        let bin = &bytes[28 + text_len..];
        assert_eq!(word(bytes, 20 + text_len) as usize, bin.len());
        let data = |accessor: &Value| {
            let accessor = &root["accessors"][number(accessor)];
            let view = &root["bufferViews"][number(&accessor["bufferView"])];
            let from = number(&view["byteOffset"]);
            (accessor, &bin[from..from + number(&view["byteLength"])])
        };
        let vectors = |accessor: &Value| -> Vec<[f32; 3]> {
            let read = |c: &[u8], i: usize| f32::from_bits(word(c, i * 4));
            let (_, bytes) = data(accessor);
            bytes
                .chunks(12)
                .map(|c| [0, 1, 2].map(|i| read(c, i)))
                .collect()
        };
        let primitives = root["meshes"][0]["primitives"].as_array().unwrap();
        let mesh = |primitive: &Value| {
            let (accessor, bytes) = data(&primitive["indices"]);
            assert_eq!(accessor["componentType"], TYPE_U16);
            let material = &root["materials"][number(&primitive["material"])];
            let factor = &material["pbrMetallicRoughness"]["baseColorFactor"];
            ShadedMesh {
                colour: [0, 1, 2].map(|i| screen(factor[i].as_f64().unwrap())),
                positions: vectors(&primitive["attributes"]["POSITION"]),
                normals: vectors(&primitive["attributes"]["NORMAL"]),
                indices: bytes
                    .chunks(2)
                    .map(|c| u32::from(u16::from_le_bytes([c[0], c[1]])))
                    .collect(),
            }
        };
        primitives.iter().map(mesh).collect()
    }

    /// The sRGB value, in steps of a hundredth, whose linear value is this.
    fn screen(value: f64) -> f32 {
        let steps = (0u8..=100).map(|step| f32::from(step) / 100.0);
        let far = |srgb: &f32| (f64::from(linear(*srgb)) - value).abs();
        steps.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap()
    }

    #[test]
    fn colours_become_linear() {
        assert_eq!(linear(0.0), 0.0);
        assert!((linear(1.0) - 1.0).abs() < 1e-6);
        // The standard's middle: half on the screen is a fifth of the light.
        assert!((linear(0.5) - 0.214).abs() < 1e-3);
    }
}
