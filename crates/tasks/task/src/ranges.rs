//! Ranges of numbers, as the schema of a kind of `[task]` gives them.

use cell_model::{Checker, ModelError};
use serde_json::Value;

/// Refuses the first number of `[task]` that is outside of the `minimum` and
/// `maximum` which `schema` gives for its key. `table` fits the schema otherwise.
///
/// # Errors
/// [`ModelError`] with file, line, key, value and range.
pub(crate) fn check(schema: &Value, table: &Value, at: &Checker<'_>) -> Result<(), ModelError> {
    Ranges { root: schema, at }.walk(schema, table, "task")
}

struct Ranges<'a> {
    root: &'a Value,
    at: &'a Checker<'a>,
}

impl Ranges<'_> {
    fn walk(&self, schema: &Value, value: &Value, key: &str) -> Result<(), ModelError> {
        // serde does not know the ranges of the schema: without this walk a number that an
        // editor marks as wrong would be accepted.
        let schema = self.resolved(schema);
        // Schemas of enums and options are lists of choices; the number belongs to the choice
        // whose required keys and constants the table has.
        for choice in ["anyOf", "oneOf"] {
            let choices = schema.get(choice).and_then(Value::as_array);
            let mut fitting = choices.into_iter().flatten();
            let fitting = fitting.find(|choice| fits(self.resolved(choice), value));
            if let Some(fitting) = fitting {
                self.walk(fitting, value, key)?;
            }
        }
        match value {
            Value::Number(number) => self.number(schema, number.as_f64().unwrap_or(f64::NAN), key),
            Value::Array(items) => items.iter().enumerate().try_for_each(|(index, item)| {
                let schema = schema.get("items").unwrap_or(&Value::Null);
                self.walk(schema, item, &format!("{key}.{index}"))
            }),
            Value::Object(table) => table.iter().try_for_each(|(name, value)| {
                // A table without fixed keys, such as a map by object name, has one schema for
                // all.
                let known = schema.get("properties").and_then(|keys| keys.get(name));
                let schema = known.or_else(|| schema.get("additionalProperties"));
                self.walk(
                    schema.unwrap_or(&Value::Null),
                    value,
                    &format!("{key}.{name}"),
                )
            }),
            Value::Null | Value::Bool(_) | Value::String(_) => Ok(()),
        }
    }

    fn number(&self, schema: &Value, value: f64, key: &str) -> Result<(), ModelError> {
        let bound = |name| schema.get(name).and_then(Value::as_f64);
        let (low, high) = (bound("minimum"), bound("maximum"));
        if low.is_none_or(|low| low <= value) && high.is_none_or(|high| value <= high) {
            return Ok(());
        }
        let allowed = match (low, high) {
            (Some(low), Some(high)) => format!("{low} to {high} is allowed"),
            (Some(low), None) => format!("{low} or more is allowed"),
            (None, high) => format!("at most {} is allowed", high.unwrap_or(f64::INFINITY)),
        };
        Err(self.at.refuse(key, value, allowed))
    }

    /// The schema itself, or the definition that it refers to.
    fn resolved<'s>(&'s self, schema: &'s Value) -> &'s Value {
        let reference = schema.get("$ref").and_then(Value::as_str);
        let pointer = reference.and_then(|reference| reference.strip_prefix('#'));
        let found = pointer.and_then(|pointer| self.root.pointer(pointer));
        found.unwrap_or(schema)
    }
}

/// Whether `value` matches this one of several schemas: it has the required keys, and
/// constant keys, such as the `kind` of a tagged table, are equal.
fn fits(schema: &Value, value: &Value) -> bool {
    let is_null = schema.get("type").and_then(Value::as_str) == Some("null");
    let required = schema.get("required").and_then(Value::as_array);
    let mut required = required.into_iter().flatten().filter_map(Value::as_str);
    let keys = schema.get("properties").and_then(Value::as_object);
    let mut keys = keys.into_iter().flatten();
    is_null == value.is_null()
        && required.all(|key| value.get(key).is_some())
        && keys.all(|(key, schema)| {
            let constant = schema.get("const");
            constant.is_none_or(|constant| value.get(key) == Some(constant))
        })
}

#[cfg(test)]
mod tests {
    use schemars::JsonSchema;
    use serde_json::json;

    use super::*;

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is used")]
    struct Task {
        #[schemars(range(min = 0.001, max = 1.0))]
        height_m: f64,
        #[schemars(inner(range(min = -2.0, max = 2.0)))]
        position_m: [f64; 3],
        #[schemars(range(min = 1, max = 5))]
        attempts: Option<u32>,
        arm: Option<Arm>,
        shape: Vec<Shape>,
        free: f64,
    }

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is used")]
    struct Arm {
        #[schemars(range(min = 0.0))]
        reach_m: f64,
    }

    #[derive(JsonSchema)]
    #[serde(tag = "kind", rename_all = "snake_case")]
    #[allow(dead_code, reason = "only its schema is used")]
    enum Shape {
        Ball {
            #[schemars(range(max = 1.0))]
            size_m: f64,
        },
        Bin {
            #[schemars(range(max = 9.0))]
            size_m: f64,
        },
    }

    fn refused(table: &Value) -> String {
        let schema = schemars::schema_for!(Task).to_value();
        let checked = check(&schema, table, &Checker::new("a.toml", ""));
        checked.map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn a_number_out_of_the_range_of_its_field_is_refused_wherever_it_is() {
        let cases = [
            (
                json!({ "height_m": 0 }),
                "task.height_m is 0; 0.001 to 1 is allowed",
            ),
            (
                json!({ "position_m": [0, 0, -2.5] }),
                "task.position_m.2 is -2.5; -2 to 2 is",
            ),
            (
                json!({ "attempts": 6 }),
                "task.attempts is 6; 1 to 5 is allowed",
            ),
            (
                json!({ "arm": { "reach_m": -1 } }),
                "task.arm.reach_m is -1; 0 or more is",
            ),
            (
                json!({ "shape": [{ "kind": "bin", "size_m": 9 }, { "kind": "ball", "size_m": 9 }] }),
                "task.shape.1.size_m is 9; at most 1 is allowed",
            ),
        ];
        for (table, expected) in cases {
            let error = refused(&table);
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn numbers_within_their_ranges_and_without_one_are_taken() {
        let table = json!({
            "height_m": 0.001, "position_m": [2, -2, 0], "attempts": 5, "arm": null,
            "shape": [{ "kind": "bin", "size_m": 9 }], "free": 1e9
        });
        assert_eq!(refused(&table), "");
    }
}
