//! `ForEach`: copies of one node, made when the file is loaded.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::build::Builder;
use super::files::get;
use super::json::{Entry, Value as Json, shortened};
use super::kinds::At;
use super::limits::{MAX_NAME, MAX_NODES};
use super::literal;
use super::nodes::Seat;
use crate::finding::Finding;
use crate::tree::{Host, Node};
use crate::value::Value;

/// An item, and the suffix of the ids of its copy.
struct Item {
    value: Value,
    text: String,
}

impl<'a, H: Host> Builder<'a, H> {
    /// A copy of `child` for each item. The work is limited by [`MAX_NODES`].
    pub(super) fn for_each(
        &mut self,
        at: At<'_, 'a>,
        entries: &'a [Entry],
        child: &'a Json,
        depth: usize,
    ) -> Option<Vec<Node<H>>> {
        let name = self.item_name(at, entries);
        let items = self.items(at, entries);
        let (name, items) = (name?, items?);
        // Removed first, so that after the loop it shows whether the child used the item.
        self.used_constants.remove(name);
        let outer = self.suffix.len();
        let mut copies = Vec::new();
        for item in items {
            if self.errors.is_full() || self.nodes > MAX_NODES {
                break;
            }
            // The item is a constant while the child is read; each copy replaces it.
            self.constants.insert(name.to_owned(), item.value);
            // Writing to a text does not fail.
            let _written = write!(self.suffix, "[{}]", item.text).is_ok();
            let seat = Seat {
                parent: at.id,
                index: 0,
                depth: depth + 1,
            };
            copies.push(self.node(at.context, child, seat));
            // Nested loops have added their own suffix by now.
            self.suffix.truncate(outer);
        }
        self.constants.remove(name);
        if !copies.is_empty() && !self.used_constants.contains(name) {
            self.findings.push(Finding {
                rule: "unused_item",
                place: at.id.to_owned(),
                message: format!(
                    "nothing in the child uses ${{{name}}}, so all copies do the same; use it, or \
                     take a Repeat"
                ),
            });
        }
        copies.into_iter().collect()
    }

    /// The name of the item: not the name of a constant, nor of an item of a loop around.
    fn item_name(&mut self, at: At<'_, 'a>, entries: &'a [Entry]) -> Option<&'a str> {
        let value = get(entries, "as")?;
        let name = value.as_text().unwrap_or_default();
        let wrong = |c: char| c.is_whitespace() || c.is_control() || "${}".contains(c);
        let message = if name.is_empty() || name.len() > MAX_NAME || name.contains(wrong) {
            format!(
                "the name of an item is a text of 1 to {MAX_NAME} bytes without spaces, '$' and \
                 braces, this is {}",
                value.describe()
            )
        } else if self.constants.contains_key(name) {
            // Hiding an outer name would change the meaning of texts that are moved into the
            // loop.
            format!(
                "'{}' is the name of a constant, or of an item of another ForEach around this one; \
                 give the item another name",
                shortened(name)
            )
        } else {
            return Some(name);
        };
        self.errors.push(at.context.file, value.place, message);
        None
    }

    fn items(&mut self, at: At<'_, 'a>, entries: &'a [Entry]) -> Option<Vec<Item>> {
        let file = at.context.file;
        let value = get(entries, "items")?;
        let Some(list) = value.as_list() else {
            let message = format!(
                "a list of items is needed here, this is {}",
                value.describe()
            );
            self.errors.push(file, value.place, message);
            return None;
        };
        if list.len() > MAX_NODES {
            let message = format!(
                "{} items, each makes a copy of the child; a tree has at most {MAX_NODES} nodes",
                list.len()
            );
            self.errors.push(file, value.place, message);
            return None;
        }
        let mut seen = BTreeSet::new();
        let mut items = Some(Vec::new());
        for (index, json) in list.iter().enumerate() {
            let item = self.item(file, json, index);
            let text = item.as_ref().map(|item| item.text.clone());
            // Two copies with the same ids would share their state in a checkpoint.
            if let Some(text) = text.filter(|text| !seen.insert(text.clone())) {
                let message = format!("item '{text}' is defined twice; ids are made of the items");
                self.errors.push(file, json.place, message);
                items = None;
            }
            items = items.zip(item).map(|(mut items, item)| {
                items.push(item);
                items
            });
        }
        items
    }

    /// An item. A list has no short text, so its copy is numbered, from 0.
    fn item(&mut self, file: &str, json: &Json, index: usize) -> Option<Item> {
        let value = self.any_literal(file, json)?;
        let text = literal::within_text(value).unwrap_or_else(|| index.to_string());
        let wrong = |c: char| c.is_whitespace() || c.is_control() || "/[]".contains(c);
        if text.is_empty() || text.contains(wrong) {
            let message = format!(
                "ids are made of the items, so an item has no spaces, '/' and brackets; this is {}",
                json.describe()
            );
            self.errors.push(file, json.place, message);
            return None;
        }
        Some(Item { value, text })
    }
}
