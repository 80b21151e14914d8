//! The elements of one file with their places.

use behavior::descriptor::json::Location;

use super::Element;
use crate::limits::MAX_NESTING;

/// Columns beyond so many bytes count bytes instead of characters.
const MAX_COUNTED: usize = 4096;

/// The text with spaces in place of comments. BehaviorTree.CPP accepts comments that XML
/// forbids, such as a line of dashes.
pub(super) fn without_comments(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("<!--") {
        let Some(end) = after.find("-->") else { break };
        plain.push_str(before);
        let comment = after.get(..end).unwrap_or_default();
        // Line breaks and the number of characters are kept, and with them all places in
        // messages.
        let blank = comment.chars().map(|c| if c == '\n' { c } else { ' ' });
        plain.push_str("    ");
        plain.extend(blank);
        plain.push_str("   ");
        rest = after.get(end + 3..).unwrap_or_default();
    }
    plain.push_str(rest);
    plain
}

/// Converts the elements of one file.
pub(super) struct Converter<'a> {
    file: &'a str,
    text: &'a str,
    /// Start of each line: a search for every element would take quadratic time.
    lines: Vec<usize>,
    pub(super) too_deep: Option<Location>,
}

impl<'a> Converter<'a> {
    pub(super) fn new(file: &'a str, text: &'a str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self {
            file,
            text,
            lines: std::iter::once(0)
                .chain(ends.map(|(at, _)| at + 1))
                .collect(),
            too_deep: None,
        }
    }

    fn place(&self, at: usize) -> Location {
        let line = self.lines.partition_point(|start| *start <= at);
        let start = self.lines.get(line.saturating_sub(1)).copied().unwrap_or(0);
        let before = self.text.get(start..at).unwrap_or_default();
        let column = match before.len() {
            // Counting in one long line would take quadratic time.
            short if short <= MAX_COUNTED => before.chars().count(),
            long => long,
        };
        let narrow = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        Location {
            line: narrow(line),
            column: narrow(column + 1),
        }
    }

    /// The recursion is limited by [`MAX_NESTING`].
    pub(super) fn element(&mut self, node: roxmltree::Node<'_, '_>, depth: usize) -> Element {
        let place = self.place(node.range().start);
        let mut children = Vec::new();
        // The first place is reported, and nothing below it is read.
        if depth >= MAX_NESTING {
            self.too_deep.get_or_insert(place);
        } else {
            let elements = node.children().filter(roxmltree::Node::is_element);
            children.extend(elements.map(|child| self.element(child, depth + 1)));
        }
        let attributes = node.attributes();
        Element {
            tag: node.tag_name().name().to_owned(),
            attributes: attributes
                .map(|a| (a.name().to_owned(), a.value().to_owned()))
                .collect(),
            children,
            file: self.file.to_owned(),
            place,
        }
    }
}
