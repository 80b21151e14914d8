//! Shapes of the objects, fixtures and links of a scene, as `foxglove.SceneUpdate`.

use cell_model::Shape;
use serde_json::{Value, json};

use crate::foxglove::{WORLD, numbers, time};
use crate::links;

/// Colour of all links; red, green and blue from 0 to 1.
const LINK_COLOUR: [f64; 3] = [0.85, 0.86, 0.88];

/// Objects and fixtures of the page's scene, and the links of its arms.
pub(crate) fn scene_update(scene: &Value) -> Value {
    let mut entities = Vec::new();
    for (list, is_object) in [("objects", true), ("fixtures", false)] {
        for item in scene[list].as_array().into_iter().flatten() {
            let name = item["name"].as_str().unwrap_or_default();
            // An object moves with its frame; a fixture is placed in the world once.
            let pose = if is_object {
                &Value::Null
            } else {
                &item["pose"]
            };
            let mut entity = entity(name, if is_object { name } else { WORLD });
            solid(&mut entity, &item["shape"], pose, &item["colour"], 0);
            entities.push(entity);
        }
    }
    for arm in scene["arms"].as_array().into_iter().flatten() {
        entities.extend(arm_entities(arm));
    }
    json!({ "deletions": [], "entities": entities })
}

/// An entity without shapes, fixed to a frame.
fn entity(id: &str, frame: &str) -> Value {
    // A lifetime of 0 means for ever: the update is sent once per file.
    json!({
        "timestamp": time(0), "frame_id": frame,
        "id": id, "lifetime": time(0), "frame_locked": true,
        "metadata": [], "arrows": [], "cubes": [], "spheres": [], "cylinders": [],
        "lines": [], "triangles": [], "texts": [], "models": [],
    })
}

/// One entity for each link that has shapes.
fn arm_entities(arm: &Value) -> Vec<Value> {
    let mut entities: Vec<Value> = Vec::new();
    for solid in links::solids(arm) {
        // A link of several shapes is one entity, so that a viewer lists links and not parts.
        let known = entities.iter().position(|one| one["id"] == *solid.frame);
        let at = known.unwrap_or_else(|| {
            entities.push(entity(&solid.frame, &solid.frame));
            entities.len() - 1
        });
        let pose = links::pose(&solid.pose);
        let pose = json!({ "position": pose.position, "orientation_wxyz": pose.orientation_wxyz });
        if let Some(entity) = entities.get_mut(at) {
            primitives(entity, &solid.shape, &pose);
        }
    }
    entities
}

/// A capsule is drawn as a cylinder of its whole length.
// Foxglove has no capsule.
fn primitives(entity: &mut Value, shape: &Shape, pose: &Value) {
    let shape = match *shape {
        Shape::Box { size_m } => json!({ "kind": "box", "size_m": size_m }),
        Shape::Sphere { radius_m } => json!({ "kind": "sphere", "radius_m": radius_m }),
        Shape::Cylinder { radius_m, height_m } => {
            json!({ "kind": "cylinder", "radius_m": radius_m, "length_m": height_m })
        }
        Shape::Capsule { radius_m, height_m } => {
            let length_m = height_m + 2.0 * radius_m;
            json!({ "kind": "capsule", "radius_m": radius_m, "length_m": length_m })
        }
        // Robots have no bins.
        Shape::Bin { .. } => return,
    };
    solid(entity, &shape, pose, &json!(LINK_COLOUR), 0);
}

/// Adds a shape; parts of parts are not drawn, as their poses would have to be multiplied.
fn solid(entity: &mut Value, shape: &Value, pose: &Value, colour: &Value, depth: u8) {
    if let Some(parts) = shape["parts"].as_array().filter(|_| depth == 0) {
        for part in parts {
            let at = if pose.is_null() { &part["pose"] } else { pose };
            solid(entity, &part["shape"], at, colour, 1);
        }
        return;
    }
    let across = 2.0 * shape["radius_m"].as_f64().unwrap_or(0.0);
    let length = shape["length_m"].as_f64().unwrap_or(0.0);
    let size = shape["size_m"]
        .as_array()
        .map(|_| numbers::<3>(&shape["size_m"]));
    let (list, [x, y, z]) = match shape["kind"].as_str() {
        Some("box") => ("cubes", size.unwrap_or_default()),
        Some("sphere") => ("spheres", [across; 3]),
        Some("cylinder" | "capsule") => ("cylinders", [across, across, length]),
        _ => return,
    };
    let body = json!({
        "pose": pose_of(pose), "size": { "x": x, "y": y, "z": z }, "color": rgba(colour),
        "bottom_scale": 1.0, "top_scale": 1.0,
    });
    if let Some(list) = entity[list].as_array_mut() {
        list.push(body);
    }
}

fn pose_of(pose: &Value) -> Value {
    let values = pose.as_array().map(|_| numbers::<7>(pose));
    let position = pose.get("position").map(numbers::<3>);
    let turn = pose.get("orientation_wxyz").map(numbers::<4>);
    let [x, y, z, w, i, j, k] = match (values, position, turn) {
        (Some(values), ..) => values,
        (_, Some([x, y, z]), Some([w, i, j, k])) => [x, y, z, w, i, j, k],
        _ => [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    };
    json!({
        "position": { "x": x, "y": y, "z": z },
        "orientation": { "x": i, "y": j, "z": k, "w": w },
    })
}

fn rgba(colour: &Value) -> Value {
    let from_text = colour.as_str().and_then(|text| {
        let number = u32::from_str_radix(text.strip_prefix('#')?, 16).ok()?;
        let part = |shift: u32| f64::from((number >> shift) & 255) / 255.0;
        Some([part(16), part(8), part(0)])
    });
    let listed = colour.as_array().map(|_| numbers::<3>(colour));
    // Grey for a colour that is missing or not readable: a
    // wrong colour must not hide an object.
    let [r, g, b] = from_text.or(listed).unwrap_or([0.6; 3]);
    json!({ "r": r, "g": g, "b": b, "a": 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_fixtures_and_links_are_fixed_to_their_frames() {
        let scene = json!({
            "objects": [{ "name": "cube", "shape": { "kind": "box", "size_m": [1, 2, 3] } }],
            "fixtures": [{ "name": "floor", "shape": { "kind": "sphere", "radius_m": 2.0 } }],
            "arms": [{
                "name": "left",
                "spheres": [
                    { "link": "hand", "center": [0, 0, 0.5], "radius": 0.1 },
                    { "link": "hand", "center": [0, 0, 0.6], "radius": 0.1 },
                ],
            }],
        });
        let update = scene_update(&scene);
        let entities = update["entities"].as_array().unwrap();
        let frames: Vec<_> = entities.iter().map(|one| &one["frame_id"]).collect();
        assert_eq!(frames, ["cube", "world", "left/hand"]);
        let spheres = entities[2]["spheres"].as_array().unwrap();
        assert_eq!(spheres.len(), 2);
        assert_eq!(spheres[1]["pose"]["position"]["z"], 0.6);
        assert_eq!(spheres[1]["size"]["x"], 0.2);
    }
}
