//! Numbers in a machine or matrix file for the code of the host: the tables
//! `[numbers]` and `[precision]`.
//!
//! The host requests each by its dotted key, with the allowed range. A number that is missing,
//! out of range or never requested is refused with its line.

use crate::descriptor::json::{Data, Entry, Value};
use crate::machine::problem::Collector;
use crate::machine::read::text;
use crate::machine::{Location, Problems};
use crate::suggest;

/// The tables of the host in a file.
pub const TABLES: [&str; 2] = ["numbers", "precision"];

/// The numbers of one file.
#[derive(Debug)]
pub struct Numbers {
    file: String,
    /// By dotted key, in the order of the text.
    all: Vec<(String, Value)>,
    asked: Vec<String>,
    problems: Collector,
}

impl Numbers {
    /// Reads the tables of a file.
    ///
    /// # Errors
    /// Syntax errors.
    pub fn read(file: &str, text: &str) -> Result<Self, Problems> {
        let root = text::parse(file, text)?;
        let mut all = Vec::new();
        for entry in root.as_object().unwrap_or_default() {
            if TABLES.contains(&entry.key.as_str()) {
                flatten(&entry.key, entry, &mut all);
            }
        }
        Ok(Self {
            file: file.to_owned(),
            all,
            asked: Vec::new(),
            problems: Collector::default(),
        })
    }

    /// The number `key`, from `low` to `high`; `low` if it is refused.
    pub fn number(&mut self, key: &str, low: f64, high: f64) -> f64 {
        let Some(value) = self.ask(key) else {
            // A valid number all the same: the host continues, and `finish` reports all
            // mistakes.
            return low;
        };
        self.in_range(key, &value, low, high)
    }

    /// As [`Numbers::number`], for a whole number.
    pub fn count(&mut self, key: &str, low: u32, high: u32) -> u32 {
        let number = self.number(key, f64::from(low), f64::from(high));
        self.whole(key, number)
    }

    /// A list of whole numbers.
    pub fn counts(&mut self, key: &str, low: u32, high: u32) -> Vec<u32> {
        let list = self.list(key, f64::from(low), f64::from(high));
        let whole = list.into_iter().map(|number| self.whole(key, number));
        whole.collect()
    }

    /// A list of numbers.
    pub fn list(&mut self, key: &str, low: f64, high: f64) -> Vec<f64> {
        let Some(value) = self.ask(key) else {
            return Vec::new();
        };
        let Some(list) = value.as_list() else {
            self.refuse(key, &format!("a list is needed, not {}", value.describe()));
            return Vec::new();
        };
        let list = list.iter();
        list.map(|value| self.in_range(key, value, low, high))
            .collect()
    }

    /// Reports that the value of `key` is wrong.
    pub fn refuse(&mut self, key: &str, why: &str) {
        let found = self.all.iter().find(|(name, _)| name == key);
        let place = found.map_or(Location { line: 1, column: 1 }, |(_, value)| {
            value.place.into()
        });
        self.problems.add(place, format!("{key}: {why}"));
    }

    /// To be called after all numbers were requested.
    ///
    /// # Errors
    /// All refused numbers, and keys that were never requested.
    pub fn finish(mut self) -> Result<(), Problems> {
        let known: Vec<&str> = self.asked.iter().map(String::as_str).collect();
        for (key, value) in &self.all {
            // A misspelt key would have no effect.
            if !known.contains(&key.as_str()) {
                let advice = suggest::advice(key, &known);
                let message = format!("nothing uses the number '{key}'; {advice}");
                self.problems.add(value.place.into(), message);
            }
        }
        self.problems.finish(&self.file, ())
    }

    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within a range, which is of u32"
    )]
    fn whole(&mut self, key: &str, number: f64) -> u32 {
        if number.trunc() < number {
            self.refuse(key, &format!("{number} is not a whole number"));
        }
        number as u32
    }

    fn ask(&mut self, key: &str) -> Option<Value> {
        self.asked.push(key.to_owned());
        let found = self.all.iter().find(|(name, _)| name == key);
        let found = found.map(|(_, value)| value.clone());
        if found.is_none() {
            let place = Location { line: 1, column: 1 };
            let message = format!("the number '{key}' is missing; add it");
            self.problems.add(place, message);
        }
        found
    }

    fn in_range(&mut self, key: &str, value: &Value, low: f64, high: f64) -> f64 {
        let number = match value.data {
            Data::Integer(number) => Some(number as f64),
            Data::Number(number) => Some(number),
            _ => None,
        };
        match number {
            Some(number) if (low..=high).contains(&number) => number,
            Some(number) => {
                let message = format!("{key} = {number}: {low} to {high} is allowed");
                self.problems.add(value.place.into(), message);
                low
            }
            None => {
                let message = format!("{key}: a number is needed, not {}", value.describe());
                self.problems.add(value.place.into(), message);
                low
            }
        }
    }
}

fn flatten(key: &str, entry: &Entry, out: &mut Vec<(String, Value)>) {
    match entry.value.as_object() {
        Some(table) => {
            for inner in table {
                flatten(&format!("{key}.{}", inner.key), inner, out);
            }
        }
        None => out.push((key.to_owned(), entry.value.clone())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "[numbers]\nsettle_s = 0.5\norder = [0, 2]\ntries = 1.5\ncolor = 1\n";

    #[test]
    fn a_number_is_within_its_range_known_and_there() {
        let mut numbers = Numbers::read("a.toml", FILE).unwrap();
        assert!((numbers.number("numbers.settle_s", 0.0, 1.0) - 0.5).abs() < 1.0e-12);
        assert_eq!(numbers.list("numbers.order", 0.0, 2.0), [0.0, 2.0]);
        numbers.list("numbers.order", 0.0, 1.0);
        numbers.count("numbers.tries", 1, 9);
        numbers.number("numbers.colour", 0.0, 1.0);
        let why = numbers.finish().unwrap_err().to_string();
        for part in [
            "a.toml:3:13: numbers.order = 2: 0 to 1 is allowed",
            "a.toml:4:9: numbers.tries: 1.5 is not a whole number",
            "a.toml:1:1: the number 'numbers.colour' is missing",
            "a.toml:5:9: nothing uses the number 'numbers.color'; did you mean 'numbers.colour'?",
        ] {
            assert!(why.contains(part), "{part}\n{why}");
        }
    }
}
