//! Values of attributes.

use behavior::value::STR_BYTES;
use serde_json::Value as Json;

/// The value of an attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Value<'a> {
    /// `{key}`.
    Key(&'a str),
    /// Any other text.
    Text(&'a str),
}

/// The value of the attribute `name`: `{=}` is the key with that name.
pub(crate) fn value<'a>(name: &'a str, text: &'a str) -> Value<'a> {
    let inner = text
        .trim()
        .strip_prefix('{')
        .and_then(|t| t.strip_suffix('}'));
    match inner.map(str::trim) {
        Some("=") => Value::Key(name),
        // BehaviorTree.CPP accepts `=` without braces as well.
        None if text == "=" => Value::Key(name),
        Some(key) if !key.is_empty() => Value::Key(key),
        _ => Value::Text(text),
    }
}

/// Why a text cannot be a value; none if it can.
pub(crate) fn no_text(text: &str) -> Option<String> {
    match text {
        _ if text.len() > STR_BYTES => {
            let found = text.len();
            Some(format!(
                "a text of {found} bytes; a value has at most {STR_BYTES}"
            ))
        }
        _ if text.contains("${") => {
            Some(format!("'${{' in '{text}' is the beginning of a constant"))
        }
        _ => None,
    }
}

/// The text of an attribute as a truth value.
pub(crate) fn truth(word: &str) -> Option<Json> {
    match word {
        // The words that BehaviorTree.CPP converts to bool.
        "true" | "True" | "TRUE" | "1" => Some(true.into()),
        "false" | "False" | "FALSE" | "0" => Some(false.into()),
        _ => None,
    }
}

/// The text of an attribute as a number.
pub(crate) fn number(word: &str) -> Option<Json> {
    let value: f64 = word.parse().ok()?;
    value.is_finite().then(|| shortest(value))
}

/// A number without a fraction where it is whole: `1`, not `1.0`.
pub(crate) fn shortest(value: f64) -> Json {
    // Whole numbers up to 2^53 are exact.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    #[allow(clippy::cast_possible_truncation, reason = "it is whole and in range")]
    if value.fract() == 0.0 && value.abs() <= EXACT {
        return (value as i64).into();
    }
    value.into()
}
