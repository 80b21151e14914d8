//! Reads the fields of a command; errors name the field.

use serde_json::{Map, Value};

/// Largest whole number that a page can represent exactly.
// Numbers of JavaScript are `f64`.
pub(super) const MAX_WHOLE: u64 = (1 << 53) - 1;
/// Longest text that is repeated in an answer (characters).
// A page must not receive its own 64 KiB back.
const SHOWN: usize = 60;

/// The fields of one command.
pub(super) struct Fields<'a>(pub(super) &'a Map<String, Value>);

impl<'a> Fields<'a> {
    /// The value of a field, or null.
    fn get(&self, key: &str) -> &'a Value {
        self.0.get(key).unwrap_or(&Value::Null)
    }

    pub(super) fn is_missing(&self, key: &str) -> bool {
        self.get(key).is_null()
    }

    pub(super) fn wrong(&self, key: &str, allowed: &str) -> String {
        let value = match self.get(key) {
            Value::Null => "missing".to_owned(),
            value => {
                let text = value.to_string();
                let shown: String = text.chars().take(SHOWN).collect();
                let dots = if shown.len() < text.len() { "..." } else { "" };
                format!("{shown}{dots}")
            }
        };
        format!("field '{key}' is {value}; it must be {allowed}")
    }

    pub(super) fn text(&self, key: &str, allowed: &str) -> Result<&'a str, String> {
        // Longer than any name or speed.
        let text = self.get(key).as_str().filter(|text| text.len() <= 256);
        text.ok_or_else(|| self.wrong(key, allowed))
    }

    pub(super) fn flag(&self, key: &str) -> Result<bool, String> {
        if self.is_missing(key) {
            return Ok(false);
        }
        self.get(key)
            .as_bool()
            .ok_or_else(|| self.wrong(key, "true or false"))
    }

    pub(super) fn whole(&self, key: &str, from: u64, to: u64) -> Result<u64, String> {
        let value = self.get(key).as_u64().filter(|n| (from..=to).contains(n));
        value.ok_or_else(|| self.wrong(key, &format!("a whole number from {from} to {to}")))
    }

    pub(super) fn number(&self, key: &str, from: f64, to: f64) -> Result<f64, String> {
        let value = self.get(key).as_f64().filter(|x| (from..=to).contains(x));
        value.ok_or_else(|| self.wrong(key, &format!("a number from {from} to {to}")))
    }

    /// At most `most` numbers within `limit`.
    pub(super) fn list(&self, key: &str, most: usize, limit: f64) -> Result<Vec<f64>, String> {
        let wrong = || {
            self.wrong(
                key,
                &format!("1 to {most} numbers from -{limit} to {limit}"),
            )
        };
        let list = self.get(key).as_array().ok_or_else(wrong)?;
        let values: Option<Vec<f64>> = list.iter().map(Value::as_f64).collect();
        let within = |values: &Vec<f64>| {
            // A comparison that is false for NaN.
            (1..=most).contains(&values.len()) && values.iter().all(|x| x.abs() <= limit)
        };
        values.filter(within).ok_or_else(wrong)
    }

    pub(super) fn numbers<const N: usize>(
        &self,
        key: &str,
        limit: f64,
    ) -> Result<[f64; N], String> {
        let wrong = || self.wrong(key, &format!("{N} numbers from -{limit} to {limit}"));
        let list = self.get(key).as_array().ok_or_else(wrong)?;
        let values: Option<Vec<f64>> = list.iter().map(Value::as_f64).collect();
        let values: [f64; N] = values.and_then(|v| v.try_into().ok()).ok_or_else(wrong)?;
        if values.iter().all(|x| x.abs() <= limit) {
            Ok(values)
        } else {
            Err(wrong())
        }
    }

    /// One of `known`.
    pub(super) fn one_of(&self, key: &str, known: &[&'static str]) -> Result<&'static str, String> {
        let text = self.get(key).as_str();
        let found = known.iter().copied().find(|word| Some(*word) == text);
        found.ok_or_else(|| self.wrong(key, &format!("one of {}", known.join(", "))))
    }
}
