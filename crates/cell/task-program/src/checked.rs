//! The findings of `check` in a file, as JSON.

use std::path::Path;

use behavior::Finding;
use schemars::JsonSchema;
use serde::Serialize;

use crate::inspect::InspectError;

/// The result of `bt|fsm check --json`.
#[derive(Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct Checked {
    /// The file, as it was named.
    file: String,
    /// Whether the file can be used.
    pub(crate) ok: bool,
    /// What has to be changed.
    errors: Vec<Mistake>,
    /// Probable mistakes.
    warnings: Vec<Warning>,
}

/// An error, with its place in the file where that is known.
#[derive(Debug, PartialEq, Eq, Serialize, JsonSchema)]
struct Mistake {
    /// Line, from 1.
    line: Option<u32>,
    /// Column in characters, from 1.
    column: Option<u32>,
    /// The mistake, and the correction.
    message: String,
}

#[derive(Debug, PartialEq, Eq, Serialize, JsonSchema)]
struct Warning {
    /// Stable name of the kind of warning.
    rule: String,
    /// Node, state, row or key.
    place: String,
    /// What, and what to do.
    message: String,
}

impl Checked {
    /// The result of checking `file`.
    pub(crate) fn new(file: &Path, found: &Result<Vec<Finding>, InspectError>) -> Self {
        let file = file.display().to_string();
        let warnings = found.iter().flatten().map(|finding| Warning {
            rule: finding.rule.to_owned(),
            place: finding.place.clone(),
            message: finding.message.clone(),
        });
        // The error type has the text for people; here it is taken apart, so that editors get
        // the same errors as a terminal.
        let text = found.as_ref().err().map(ToString::to_string);
        let lines = text.iter().flat_map(|text| text.lines());
        Self {
            ok: found.is_ok(),
            errors: lines.map(|line| Mistake::of(line, &file)).collect(),
            warnings: warnings.collect(),
            file,
        }
    }
}

impl Mistake {
    /// From a line `FILE:LINE:COLUMN: MESSAGE`; an error of another file keeps its name.
    fn of(text: &str, file: &str) -> Self {
        let place = |text: &str| {
            let rest = text.strip_prefix(file)?.strip_prefix(':')?;
            // Any part that does not parse gives up the place, never the message.
            let (line, rest) = rest.split_once(':')?;
            let (column, message) = rest.split_once(": ")?;
            Some(Self {
                line: Some(line.parse().ok()?),
                column: Some(column.parse().ok()?),
                message: message.to_owned(),
            })
        };
        place(text).unwrap_or_else(|| Self {
            line: None,
            column: None,
            message: text.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_has_its_place_where_its_file_is_the_checked_one() {
        let wrong = "a.json:3:7: unknown type\nb.json:1:1: not a tree".to_owned();
        let checked = Checked::new(Path::new("a.json"), &Err(InspectError::Behaviour(wrong)));
        let places: Vec<_> = checked.errors.iter().map(|e| (e.line, e.column)).collect();
        assert_eq!(places, [(Some(3), Some(7)), (None, None)]);
        assert_eq!(checked.errors[0].message, "unknown type");
        assert_eq!(checked.errors[1].message, "b.json:1:1: not a tree");
    }
}
