//! Names of one kind, found without a search through their list.

use std::collections::BTreeMap;

use crate::descriptor::advice;
use crate::descriptor::json::shortened;
use crate::machine::Name;
use crate::machine::problem::Collector;

/// Names in their order; a duplicate name has the index of the first.
#[derive(Debug, Default)]
pub(crate) struct Known {
    names: Vec<String>,
    places: BTreeMap<String, usize>,
}

impl Known {
    pub(crate) fn new<S: AsRef<str>>(names: impl IntoIterator<Item = S>) -> Self {
        let mut known = Self::default();
        for name in names {
            known.push(name.as_ref());
        }
        known
    }

    /// Adds a name; returns its index.
    pub(crate) fn push(&mut self, name: &str) -> usize {
        let place = self.names.len();
        self.names.push(name.to_owned());
        *self.places.entry(name.to_owned()).or_insert(place)
    }

    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }

    /// The index of `name`; an unknown name is reported.
    pub(crate) fn look_up(
        &self,
        what: &str,
        name: &Name,
        problems: &mut Collector,
    ) -> Option<usize> {
        let found = self.find(&name.text);
        if found.is_none() {
            // Composed only if it is shown: the search for the intended name takes time.
            problems.add_with(name.place, || {
                let known: Vec<&str> = self.names.iter().map(String::as_str).collect();
                let text = shortened(&name.text);
                let advice = advice::advice(&text, &known);
                format!("unknown {what} '{text}'; {advice}")
            });
        }
        found
    }

    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    pub(crate) fn into_names(self) -> Vec<String> {
        self.names
    }
}
