//! Memory layout of our own structs as JSON, so that a reader in any language can take them
//! apart.

use ipc_types::layout::{FieldLayout, StructLayout};
use ipc_types::{Wire, layout_of};
use serde_json::{Map, Value, json};

/// `schema_encoding` of the channels of structs.
pub(crate) const ENCODING: &str = "robocell/layout";

/// The layout of `T` and of every struct in it: `{"root", "byte_order",
/// "structs": {NAME: {"size", "fields": [{"name", "type", "offset", "count"}]}}}`.
pub(crate) fn of<T: Wire>() -> String {
    let (root, _count) = T::element();
    let structs: Map<String, Value> = layout_of::<T>().iter().map(entry).collect();
    json!({ "root": root, "byte_order": "little", "structs": structs }).to_string()
}

fn entry(layout: &StructLayout) -> (String, Value) {
    let fields: Vec<Value> = layout.fields.iter().map(field).collect();
    let value = json!({ "size": layout.bytes, "fields": fields });
    (layout.name.to_owned(), value)
}

fn field(field: &FieldLayout) -> Value {
    json!({
        "name": field.name,
        "type": field.element,
        "offset": field.offset,
        "count": field.count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::WorldPiece;

    #[test]
    fn a_reader_that_knows_nothing_else_finds_a_joint_of_a_piece() {
        let mut piece = WorldPiece::zeroed();
        piece.arms[1].joint_velocities[2] = 0.25;
        let layout: Value = serde_json::from_str(&of::<WorldPiece>()).unwrap();
        let offset = |of: &str, field: &str| {
            let fields = layout["structs"][of]["fields"].as_array().unwrap();
            let field = fields.iter().find(|f| f["name"] == field).unwrap();
            field["offset"].as_u64().unwrap() as usize
        };
        let arm_bytes = layout["structs"]["ArmState"]["size"].as_u64().unwrap() as usize;
        let at = offset("WorldPiece", "arms")
            + arm_bytes
            + offset("ArmState", "joint_velocities")
            + 2 * 8;
        let bytes = piece.as_bytes()[at..at + 8].try_into().unwrap();
        assert_eq!(f64::from_le_bytes(bytes), 0.25);
    }
}
