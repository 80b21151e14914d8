//! YAML with errors that a person can act on: file, line, key, "did you mean".

use serde::de::DeserializeOwned;
use serde_saphyr::Error;

use crate::error::{Location, ModelError};
use crate::suggest;

/// Reads `text` as `T`; keys unknown to `T` are refused where `T` denies them.
pub(crate) fn parse<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, ModelError> {
    serde_saphyr::from_str(text).map_err(|error| explain(file, &error))
}

fn explain(file: &str, error: &Error) -> ModelError {
    let error = error.without_snippet();
    let line = error
        .location()
        .map(|at| at.line())
        .and_then(|line| usize::try_from(line).ok());
    // The parser gives line 0 where it knows none.
    let place = Location::line(file, line.filter(|line| *line > 0));
    if let Error::SerdeUnknownField {
        field, expected, ..
    } = error
    {
        return ModelError::UnknownKey {
            place,
            key: field.clone(),
            advice: suggest::advice(field, expected),
        };
    }
    let message = error.to_string().trim().replace('\n', "; ");
    ModelError::Syntax { place, message }
}

/// The refusal of a value, with the line of its key.
pub(crate) fn refuse(
    file: &str,
    text: &str,
    key: &str,
    value: impl std::fmt::Display,
    allowed: impl Into<String>,
) -> ModelError {
    ModelError::value(
        Location::line(file, line_of(text, key)),
        key,
        value,
        allowed,
    )
}

/// Line of a dotted key path in block style: each part is searched for after the one before.
/// Indices in brackets are skipped.
pub(crate) fn line_of(text: &str, path: &str) -> Option<usize> {
    let mut lines = text.lines().enumerate();
    let mut found = None;
    for part in path.split('.') {
        let key = part.split('[').next().unwrap_or(part);
        let holds = |line: &str| {
            let code = line.split('#').next().unwrap_or("");
            let at = code.find(key);
            at.is_some_and(|at| {
                let before = code[..at].trim_start_matches([' ', '-', '{', '"', '\'']);
                let after = code[at + key.len()..].trim_start_matches(['"', '\'', ' ']);
                before.is_empty() && after.starts_with(':')
            })
        };
        match lines.find(|(_, line)| holds(line)) {
            Some((index, _)) => found = Some(index + 1),
            None => break,
        }
    }
    found
}
