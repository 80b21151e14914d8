//! The part of JSON Schema that describes what the commands print.

use serde_json::Value;

/// What in `value` is not as `schema` says: keys that are missing or not described, and
/// values of another type. Empty where all is well.
pub fn differences(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    look(schema, schema, value, "$", &mut found);
    found
}

fn look(root: &Value, schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    if let Some(path) = schema["$ref"].as_str() {
        let target = root.pointer(path.trim_start_matches('#'));
        let target = target.unwrap_or_else(|| panic!("{path} is not in the schema"));
        return look(root, target, value, at, found);
    }
    if let Some(any) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
        let fits = |one: &Value| {
            let mut wrong = Vec::new();
            look(root, one, value, at, &mut wrong);
            wrong.is_empty()
        };
        if !any.iter().any(fits) {
            found.push(format!("{at}: fits none of {}", any.len()));
        }
        return;
    }
    if !is_of_type(&schema["type"], value) {
        found.push(format!("{at}: {value} is no {}", schema["type"]));
    }
    if let Some(known) = schema["enum"].as_array().filter(|all| !all.contains(value)) {
        found.push(format!("{at}: {value} is none of {known:?}"));
    }
    if let Some(only) = schema.get("const").filter(|only| *only != value) {
        found.push(format!("{at}: {value} is not {only}"));
    }
    object(root, schema, value, at, found);
    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
        let tuple = schema["prefixItems"].get(index);
        let inner = tuple.unwrap_or(&schema["items"]);
        look(root, inner, item, &format!("{at}[{index}]"), found);
    }
}

fn object(root: &Value, schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    let Some(object) = value.as_object() else {
        return;
    };
    for (key, item) in object {
        let described = schema["properties"].get(key);
        let rest = Some(&schema["additionalProperties"]).filter(|rest| rest.is_object());
        match described.or(rest) {
            Some(inner) => look(root, inner, item, &format!("{at}.{key}"), found),
            None => found.push(format!("{at}.{key} is not described")),
        }
    }
    let required = schema["required"].as_array().into_iter().flatten();
    for key in required.filter_map(Value::as_str) {
        if !object.contains_key(key) {
            found.push(format!("{at}.{key} is missing"));
        }
    }
}

fn is_of_type(wanted: &Value, value: &Value) -> bool {
    let is = |word: &str| match word {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        _ => false,
    };
    match wanted {
        Value::String(word) => is(word),
        Value::Array(words) => words.iter().filter_map(Value::as_str).any(is),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::differences;
    use serde_json::json;

    #[test]
    fn what_is_missing_undescribed_or_of_another_type_is_told() {
        let schema = json!({
            "type": "object",
            "properties": {"a": {"type": ["integer", "null"]}, "b": {"$ref": "#/$defs/b"}},
            "required": ["a"],
            "$defs": {"b": {"type": "array", "items": {"enum": ["x"]}}}
        });
        assert_eq!(
            differences(&schema, &json!({"a": null, "b": ["x"]})),
            [""; 0]
        );
        let wrong = differences(&schema, &json!({"b": ["y", "x"], "c": 1}));
        assert_eq!(wrong.len(), 3, "{wrong:?}");
        assert_eq!(differences(&schema, &json!({"a": 1.5})).len(), 1);
    }
}
