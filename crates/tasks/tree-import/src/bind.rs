//! Values of attributes.

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
