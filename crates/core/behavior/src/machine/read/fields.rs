//! Keys of an object; a key that does not belong there is reported.

use crate::descriptor::json::{Data, Entry, Value, shortened};
use crate::machine::definition::Name;
use crate::machine::problem::{Collector, Location};
use crate::suggest;

/// Largest length of a name (bytes).
// Names are part of trace lines, which have 160 bytes.
const MAX_NAME: usize = 128;

impl From<crate::descriptor::json::Location> for Location {
    fn from(place: crate::descriptor::json::Location) -> Self {
        Self {
            line: place.line,
            column: place.column,
        }
    }
}

/// The entries of an object whose keys are known.
pub(crate) struct Fields<'v> {
    pub(crate) place: Location,
    what: &'static str,
    entries: &'v [Entry],
}

impl<'v> Fields<'v> {
    /// The entries of `value`; each key that is not in `known` is reported.
    pub(crate) fn open(
        value: &'v Value,
        what: &'static str,
        known: &[&str],
        problems: &mut Collector,
    ) -> Option<Self> {
        let Some(entries) = value.as_object() else {
            let message = format!(
                "{what} is expected here as a table, not {}",
                value.describe()
            );
            problems.add(value.place.into(), message);
            return None;
        };
        for entry in entries {
            if !known.contains(&entry.key.as_str()) {
                problems.add_with(entry.place.into(), || {
                    let key = shortened(&entry.key);
                    let advice = suggest::advice(&key, known);
                    format!("{what} has no key '{key}'; {advice}")
                });
            }
        }
        Some(Self {
            place: value.place.into(),
            what,
            entries,
        })
    }

    pub(crate) fn get(&self, key: &str) -> Option<&'v Value> {
        let entry = self.entries.iter().find(|entry| entry.key == key)?;
        Some(&entry.value)
    }

    fn wrong(&self, key: &str, expected: &str, value: &Value, problems: &mut Collector) {
        let message = format!(
            "'{key}' of {} must be {expected}, not {}",
            self.what,
            value.describe()
        );
        problems.add(value.place.into(), message);
    }

    /// The name at `key`, if there is one.
    pub(crate) fn name(&self, key: &str, problems: &mut Collector) -> Option<Name> {
        let value = self.get(key)?;
        let name = name_of(value, problems);
        if name.is_none() && value.as_text().is_none() {
            self.wrong(key, "a text", value, problems);
        }
        name
    }

    /// The name at `key`; reported if missing.
    pub(crate) fn required(&self, key: &str, problems: &mut Collector) -> Option<Name> {
        if self.get(key).is_none() {
            let message = format!("{} has no '{key}'; add {key} = \"...\"", self.what);
            problems.add(self.place, message);
        }
        self.name(key, problems)
    }

    /// One name or a list of names; none if the key is not there.
    pub(crate) fn names(&self, key: &str, problems: &mut Collector) -> Vec<Name> {
        let Some(value) = self.get(key) else {
            return Vec::new();
        };
        match &value.data {
            Data::Text(_) => name_of(value, problems).into_iter().collect(),
            Data::Null => Vec::new(),
            Data::List(items) => items
                .iter()
                .filter_map(|item| {
                    if item.as_text().is_none() {
                        self.wrong(key, "a list of texts", item, problems);
                    }
                    name_of(item, problems)
                })
                .collect(),
            _ => {
                self.wrong(key, "a text or a list of texts", value, problems);
                Vec::new()
            }
        }
    }

    /// A flag; `default` if the key is not there.
    pub(crate) fn flag(&self, key: &str, default: bool, problems: &mut Collector) -> bool {
        match self.get(key).map(|value| (value, &value.data)) {
            None => default,
            Some((_, Data::Bool(flag))) => *flag,
            Some((value, _)) => {
                self.wrong(key, "true or false", value, problems);
                default
            }
        }
    }

    /// The values of a list; none if the key is not there.
    pub(crate) fn list(&self, key: &str, problems: &mut Collector) -> &'v [Value] {
        match self.get(key).map(|value| (value, &value.data)) {
            None => &[],
            Some((_, Data::List(items))) => items,
            Some((value, _)) => {
                self.wrong(key, "a list", value, problems);
                &[]
            }
        }
    }

    /// The entries of a table; none if the key is not there.
    pub(crate) fn table(&self, key: &str, problems: &mut Collector) -> &'v [Entry] {
        match self.get(key).map(|value| (value, value.as_object())) {
            None => &[],
            Some((_, Some(entries))) => entries,
            Some((value, None)) => {
                self.wrong(key, "a table", value, problems);
                &[]
            }
        }
    }

    /// Whether each of these tables has at most so many entries; reported otherwise. To
    /// be called before they are read: reading takes time for each entry.
    pub(crate) fn fit(&self, limits: &[(&str, usize)], problems: &mut Collector) -> bool {
        let before = problems.0.len();
        for (key, most) in limits {
            let entries = self.get(key).and_then(Value::as_object).unwrap_or_default();
            if let Some(beyond) = entries.get(*most) {
                let message = format!("{} {key}; at most {most} can be", entries.len());
                problems.add(beyond.place.into(), message);
            }
        }
        problems.0.len() == before
    }

    /// Reports a file without `version = 1`.
    pub(crate) fn check_version(&self, problems: &mut Collector) {
        let message = match self.get("version").map(|it| (it, &it.data)) {
            Some((_, Data::Integer(1))) => return,
            None => "the file does not say its format; add version = 1".to_owned(),
            Some((value, _)) => format!("version is {}, this program reads 1", value.describe()),
        };
        let place = self.get("version").map(|value| value.place.into());
        problems.add(place.unwrap_or(self.place), message);
    }
}

/// The name in a text, unless it is too long.
pub(crate) fn name_of(value: &Value, problems: &mut Collector) -> Option<Name> {
    let text = value.as_text()?;
    let place = value.place.into();
    if text.len() > MAX_NAME {
        let message = format!("'{}' is longer than {MAX_NAME} bytes", shortened(text));
        problems.add(place, message);
        return None;
    }
    Some(Name {
        text: text.to_owned(),
        place,
    })
}
