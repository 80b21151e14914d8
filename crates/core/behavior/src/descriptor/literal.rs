//! Values as written in files.

use super::json::{Data, Value as Json};
use crate::value::{MAX_NUMBERS, Numbers, STR_BYTES, Set, Str, Value, ValueType};

/// The form of a value of `value_type`, with its article.
pub(super) fn wanted(value_type: ValueType) -> String {
    match value_type {
        ValueType::Bool => "true or false".to_owned(),
        ValueType::Integer => "an integer".to_owned(),
        ValueType::Number => "a number".to_owned(),
        ValueType::Text => format!("a text of at most {STR_BYTES} bytes"),
        ValueType::Numbers => format!("a list of at most {MAX_NUMBERS} numbers"),
        ValueType::Set => "a list of integers from 0 to 63".to_owned(),
    }
}

/// `json` as a value of that type.
pub(super) fn typed(json: &Json, value_type: ValueType) -> Result<Value, String> {
    let value = match (value_type, &json.data) {
        (ValueType::Bool, Data::Bool(value)) => Some(Value::Bool(*value)),
        (ValueType::Integer, Data::Integer(value)) => Some(Value::Integer(*value)),
        (ValueType::Number, _) => number(json).map(Value::Number),
        (ValueType::Text, Data::Text(text)) => Str::new(text).map(Value::Text),
        (ValueType::Numbers, Data::List(items)) => numbers(items).map(Value::Numbers),
        (ValueType::Set, Data::List(items)) => set(items).map(Value::Set),
        _ => None,
    };
    value.ok_or_else(|| {
        let wanted = wanted(value_type);
        format!("{wanted} is needed here, this is {}", json.describe())
    })
}

/// `json` as a value of the type that its form implies.
pub(super) fn untyped(json: &Json) -> Result<Value, String> {
    let value_type = match &json.data {
        Data::Bool(_) => ValueType::Bool,
        Data::Integer(_) => ValueType::Integer,
        Data::Number(_) => ValueType::Number,
        Data::Text(_) => ValueType::Text,
        // A longer list can only be a set.
        Data::List(items) if items.len() > MAX_NUMBERS => ValueType::Set,
        Data::List(_) => ValueType::Numbers,
        Data::Null | Data::Object(_) => {
            return Err(format!(
                "a value is needed here, this is {}",
                json.describe()
            ));
        }
    };
    typed(json, value_type)
}

/// `value` as a value of that type, if no information is lost.
pub(super) fn coerced(value: Value, value_type: ValueType) -> Option<Value> {
    match (value, value_type) {
        (value, wanted) if value.value_type() == wanted => Some(value),
        (Value::Integer(integer), ValueType::Number) => Some(Value::Number(integer as f64)),
        // A list of small whole numbers looks the same as a set until its type is known.
        (Value::Numbers(numbers), ValueType::Set) => {
            let items = numbers.as_slice().iter();
            let mut bits = items.map(|item| whole(*item).and_then(bit));
            let all = bits.try_fold(0, |all, bit| Some(all | bit?))?;
            Some(Value::Set(Set(all)))
        }
        _ => None,
    }
}

/// `value` within a text, for names and keys.
pub(super) fn within_text(value: Value) -> Option<String> {
    match value {
        Value::Bool(value) => Some(value.to_string()),
        Value::Integer(value) => Some(value.to_string()),
        Value::Number(value) => Some(value.to_string()),
        Value::Text(text) => Some(text.as_str().to_owned()),
        Value::Numbers(_) | Value::Set(_) => None,
    }
}

fn number(json: &Json) -> Option<f64> {
    match json.data {
        Data::Integer(value) => Some(value as f64),
        Data::Number(value) => Some(value),
        _ => None,
    }
}

fn numbers(items: &[Json]) -> Option<Numbers> {
    if items.len() > MAX_NUMBERS {
        return None;
    }
    let all: Option<Vec<f64>> = items.iter().map(number).collect();
    Numbers::new(&all?)
}

fn set(items: &[Json]) -> Option<Set> {
    let mut bits = items.iter().map(|item| match item.data {
        Data::Integer(integer) => bit(integer),
        _ => None,
    });
    Some(Set(bits.try_fold(0, |all, bit| Some(all | bit?))?))
}

fn whole(number: f64) -> Option<i64> {
    let fits = number.fract() == 0.0 && (0.0..64.0).contains(&number);
    #[allow(clippy::cast_possible_truncation, reason = "checked to be 0 to 63")]
    fits.then_some(number as i64)
}

fn bit(item: i64) -> Option<u64> {
    1_u64.checked_shl(u32::try_from(item).ok()?)
}
