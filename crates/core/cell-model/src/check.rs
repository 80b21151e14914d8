//! Checks of the numbers in a file that a person wrote.

use std::fmt::Display;

use crate::error::{Location, ModelError};
use crate::toml_text;

/// Largest coordinate within a cell (m).
pub const MAX_COORDINATE_M: f64 = 20.0;

/// Refuses values of a file. Every refusal names file, line, key, value and the allowed range.
/// Keys are dotted paths such as `object.2.mass_kg`.
#[derive(Clone, Copy, Debug)]
pub struct Checker<'a> {
    file: &'a str,
    text: &'a str,
}

impl<'a> Checker<'a> {
    /// A checker for the file with this name in messages and this text.
    pub fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text }
    }

    /// The line of `key`, or of the table it would be in.
    pub fn line_of(&self, key: &str) -> Location {
        Location::line(self.file, toml_text::line_of(self.text, key))
    }

    /// The error for `value` of `key`, with the allowed values.
    pub fn refuse(&self, key: &str, value: impl Display, allowed: impl Into<String>) -> ModelError {
        ModelError::value(self.line_of(key), key, value, allowed)
    }

    /// Refuses a number outside of `low` to `high`, and NaN.
    ///
    /// # Errors
    /// [`ModelError::Value`].
    pub fn number(&self, key: &str, value: f64, low: f64, high: f64) -> Result<(), ModelError> {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(self.refuse(key, value, format!("{low} to {high} is allowed")))
    }

    /// As [`Checker::number`], for each of `values`.
    ///
    /// # Errors
    /// [`ModelError::Value`].
    pub fn numbers(
        &self,
        key: &str,
        values: &[f64],
        low: f64,
        high: f64,
    ) -> Result<(), ModelError> {
        values.iter().enumerate().try_for_each(|(index, value)| {
            self.number(&format!("{key}.{index}"), *value, low, high)
        })
    }

    /// Key, value, smallest and largest allowed, of numbers in one `table`.
    ///
    /// # Errors
    /// [`ModelError::Value`].
    pub fn ranges(&self, table: &str, ranges: &[(&str, f64, f64, f64)]) -> Result<(), ModelError> {
        ranges.iter().try_for_each(|(key, value, low, high)| {
            self.number(&format!("{table}.{key}"), *value, *low, *high)
        })
    }

    /// Refuses a position outside of the largest cell (m).
    ///
    /// # Errors
    /// [`ModelError::Value`].
    pub fn position(&self, key: &str, position: &[f64; 3]) -> Result<(), ModelError> {
        self.numbers(key, position, -MAX_COORDINATE_M, MAX_COORDINATE_M)
    }
}
