//! Numbers of a cell file that a run replaces, for `--set` and `--vary`.
//!
//! A key is a dotted path such as `task.timeout_s` or `object.red_cube.mass_kg`. An entry of a
//! list of tables is found by its name, or by its index from 0; `*` is every entry.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use serde_json::Number;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Location, ModelError};
use crate::{suggest, toml_text};

/// A key and its number.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setting {
    /// Dotted path; see the module.
    pub key: String,
    /// As it was written: 4 is an integer, 4.0 is not.
    pub value: Number,
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.key, self.value)
    }
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let allowed =
            || format!("{text:?} is not a setting; write KEY=NUMBER, as task.timeout_s=4");
        let (key, value) = text.split_once('=').ok_or_else(allowed)?;
        Ok(Self {
            key: key_of(key)?,
            value: number(value).ok_or_else(allowed)?,
        })
    }
}

/// The numbers of `settings` by their keys.
pub fn by_key<'a>(settings: impl IntoIterator<Item = &'a Setting>) -> BTreeMap<String, Number> {
    let pairs = settings.into_iter();
    let pairs = pairs.map(|setting| (setting.key.clone(), setting.value.clone()));
    pairs.collect()
}

/// A key as it is written in arguments.
pub(crate) fn key_of(text: &str) -> Result<String, String> {
    let word = |part: &str| {
        let of_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        part == "*" || (!part.is_empty() && part.chars().all(of_word))
    };
    let key = text.trim();
    if key.split('.').all(word) {
        return Ok(key.to_owned());
    }
    Err(format!(
        "{text:?} is not a key of a cell file; write a dotted path, as task.timeout_s or object.*.mass_kg"
    ))
}

/// A finite number; integers stay integers.
pub(crate) fn number(text: &str) -> Option<Number> {
    let text = text.trim();
    // Integers first: a key of integers refuses 4.0.
    let whole = text.parse::<i64>().ok().map(Number::from);
    whole.or_else(|| Number::from_f64(text.parse().ok()?))
}

/// The text of a cell file with these numbers in place of its own. A key that the file does not
/// have is added; reading the text decides whether the cell knows it.
///
/// # Errors
/// Returns [`ModelError`] for a key that is not the path of a number.
pub(crate) fn apply(file: &str, text: &str, settings: &[Setting]) -> Result<String, ModelError> {
    let mut text = text.to_owned();
    // One after the other: two settings may add keys to the same table.
    for setting in settings {
        let value = setting.value.to_string();
        // From the last to the first, so that the positions before stay valid.
        let mut places = places(file, &text, &setting.key)?;
        places.sort_by_key(|place| std::cmp::Reverse(place.at.start));
        for place in places {
            let new = match place.kind {
                Kind::Missing => format!("{}{value}\n", place.before),
                Kind::Integer | Kind::Float => value.clone(),
            };
            text.replace_range(place.at, &new);
        }
    }
    Ok(text)
}

/// The kind of a number in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An integer.
    Integer,
    /// A number that is not an integer.
    Float,
    /// Missing.
    Missing,
}

/// The position of a number, or of a missing one.
#[derive(Debug)]
pub(crate) struct Place {
    /// Its own path, with names in place of `*`.
    pub(crate) path: String,
    /// Its kind.
    pub(crate) kind: Kind,
    /// Bytes to replace.
    at: Range<usize>,
    /// Text before a number that is added.
    before: String,
}

/// The positions of the numbers of a key, in the order of the file.
pub(crate) fn places(file: &str, text: &str, key: &str) -> Result<Vec<Place>, ModelError> {
    let root = toml_text::table(file, text)?;
    let mut finder = Finder {
        file,
        text,
        key,
        found: Vec::new(),
    };
    let keys: Vec<&str> = key.split('.').collect();
    finder.table(root.get_ref(), None, &keys, "")?;
    Ok(finder.found)
}

struct Finder<'a> {
    file: &'a str,
    text: &'a str,
    key: &'a str,
    found: Vec<Place>,
}

impl Finder<'_> {
    /// `header` is the position of the table; `None` for the whole file.
    fn table(
        &mut self,
        table: &DeTable<'_>,
        header: Option<usize>,
        keys: &[&str],
        path: &str,
    ) -> Result<(), ModelError> {
        let Some((first, rest)) = keys.split_first() else {
            return Err(self.refuse(path, "a table"));
        };
        if *first == "*" {
            for (name, value) in table {
                self.value(value, rest, &toml_text::join(path, name.get_ref()))?;
            }
            return Ok(());
        }
        let path = toml_text::join(path, first);
        match table.get(*first) {
            Some(value) => self.value(value, rest, &path),
            None => self.missing(header, (first, rest), path),
        }
    }

    fn value(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        keys: &[&str],
        path: &str,
    ) -> Result<(), ModelError> {
        let at = value.span();
        let kind = match value.get_ref() {
            DeValue::Table(table) => return self.table(table, Some(at.start), keys, path),
            DeValue::Array(array) => return self.array(array, keys, path),
            DeValue::Integer(_) if keys.is_empty() => Kind::Integer,
            DeValue::Float(_) if keys.is_empty() => Kind::Float,
            _ => return Err(self.refuse(path, "not a number")),
        };
        self.found.push(Place {
            path: path.to_owned(),
            kind,
            at,
            before: String::new(),
        });
        Ok(())
    }

    /// An entry has a name, or its index from 0.
    fn array(
        &mut self,
        array: &[Spanned<DeValue<'_>>],
        keys: &[&str],
        path: &str,
    ) -> Result<(), ModelError> {
        let Some((first, rest)) = keys.split_first() else {
            return Err(self.refuse(path, "a list"));
        };
        let names: Vec<String> = array
            .iter()
            .enumerate()
            .map(|(index, value)| name_of(value).map_or_else(|| index.to_string(), str::to_owned))
            .collect();
        let index = first.parse().ok();
        let entries = array.iter().zip(&names).enumerate();
        let mut any = false;
        for (at, (value, name)) in entries {
            if *first == "*" || first == name || index == Some(at) {
                any = true;
                self.value(value, rest, &toml_text::join(path, name))?;
            }
        }
        if any {
            return Ok(());
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        Err(ModelError::value(
            Location::line(self.file, toml_text::line_of(self.text, path)),
            self.key,
            "not a key of this cell",
            format!("{path}: {}", suggest::advice(first, &names)),
        ))
    }

    fn missing(
        &mut self,
        header: Option<usize>,
        (first, rest): (&str, &[&str]),
        path: String,
    ) -> Result<(), ModelError> {
        let Some((last, tables)) = rest.split_last() else {
            // A line below the header, or the first one of the file.
            let rest = &self.text[header.unwrap_or(0)..];
            let at = match header {
                None => 0,
                Some(start) if rest.starts_with('[') => {
                    start + rest.find('\n').map_or(rest.len(), |end| end + 1)
                }
                // A table in braces has no line below its header in which a key could be added.
                Some(_) => return Err(self.refuse(&path, "not there")),
            };
            self.add(at, format!("{first} = "), path);
            return Ok(());
        };
        // Only at the end of the file: a new table in the middle would take the keys that
        // follow it.
        if header.is_some() || rest.contains(&"*") {
            return Err(self.refuse(&path, "not there"));
        }
        let tables: Vec<&str> = std::iter::once(first)
            .chain(tables.iter().copied())
            .collect();
        let header = format!("\n[{}]\n{last} = ", tables.join("."));
        self.add(self.text.len(), header, self.key.to_owned());
        Ok(())
    }

    fn add(&mut self, at: usize, before: String, path: String) {
        self.found.push(Place {
            path,
            kind: Kind::Missing,
            at: at..at,
            before,
        });
    }

    fn refuse(&self, path: &str, what: &str) -> ModelError {
        ModelError::value(
            Location::line(self.file, toml_text::line_of(self.text, path)),
            path,
            what,
            format!("{} must be a number of the cell file", self.key),
        )
    }
}

fn name_of<'a>(value: &'a Spanned<DeValue<'_>>) -> Option<&'a str> {
    match value.get_ref() {
        DeValue::Table(table) => table.get("name")?.get_ref().as_str(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a = 1\n[[object]]\nname = \"red\"\nmass = 2.0 # kg\nat = [0.0, 1]\n\
        [[object]]\nname = \"blue\"\nspawn = { x = 1 }\n[task]\nkind = \"stack\"\ntimeout_s = 5.0\n";

    fn with(settings: &[&str]) -> Result<String, String> {
        let settings: Result<Vec<Setting>, _> = settings.iter().map(|text| text.parse()).collect();
        apply("c.toml", TEXT, &settings?).map_err(|error| error.to_string())
    }

    #[test]
    fn numbers_are_replaced_where_they_are_and_added_where_they_are_not() {
        let same = TEXT.replace("5.0", "4").replace("2.0", "0.5");
        assert_eq!(
            with(&["task.timeout_s=4", "object.red.mass=0.5"]),
            Ok(same.clone())
        );
        assert_eq!(with(&["object.0.mass=0.5", "task.timeout_s=4"]), Ok(same));
        let every = with(&["object.*.mass=0.1", "object.red.at.1=-3.5"]).unwrap();
        assert!(
            every.contains("mass = 0.1 # kg\nat = [0.0, -3.5]"),
            "{every}"
        );
        assert!(every.contains("[[object]]\nmass = 0.1\nname = \"blue\""));
        let new = with(&["task.height_m=1e-7", "b=2", "noise.x_m=1", "noise.y_m=2"]).unwrap();
        assert!(new.starts_with("b = 2\na = 1\n"), "{new}");
        assert!(new.contains("[task]\nheight_m = 1e-7\nkind"), "{new}");
        assert!(new.ends_with("\n[noise]\ny_m = 2\nx_m = 1\n"), "{new}");
    }

    #[test]
    fn a_key_that_leads_to_no_number_is_named_with_its_line() {
        for (setting, expected) in [
            (
                "task.kind=1",
                "c.toml:10: task.kind is not a number; task.kind must be a number of the cell file",
            ),
            ("object=1", "c.toml:2: object is a list; object must be"),
            (
                "object.red=1",
                "c.toml:2: object.red is a table; object.red must",
            ),
            (
                "object.rad.mass=1",
                "c.toml:2: object.rad.mass is not a key of this cell; object: did you mean 'red'?",
            ),
            ("object.blue.spawn.y=1", "object.blue.spawn.y is not there"),
            ("a.b=1", "c.toml:1: a is not a number"),
            ("a b=1", "\"a b\" is not a key of a cell file"),
            ("a=nan", "\"a=nan\" is not a setting"),
            ("a=inf", "is not a setting"),
            ("a", "is not a setting"),
            ("=1", "is not a key"),
        ] {
            let error = with(&[setting]).unwrap_err();
            assert!(error.contains(expected), "{setting}: {error}");
        }
    }
}
