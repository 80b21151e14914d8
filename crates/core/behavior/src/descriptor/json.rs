//! JSON with the place of every value, for messages that refer to it.
//!
//! Plain JSON only, so that any other tool reads the same files. Refused are a duplicate key,
//! a number beyond the range of 64-bit floating point, and texts that
//! are too large or nested too deep.

use std::collections::BTreeMap;

use jsonc_parser::ast;
use jsonc_parser::errors::ParseErrorKind;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

use super::error::Errors;
use crate::lines::Lines;
pub use crate::lines::Location;

/// Largest size of a file (bytes).
// A file that is not meant, such as a mesh, is not read into memory as a tree.
pub const MAX_BYTES: usize = 4 << 20;
/// Largest nesting of objects and lists.
// Bounds the recursion of the reader; two levels for each node within a node.
pub const MAX_DEPTH: usize = 128;

/// A value and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// The place of its first character.
    pub place: Location,
    /// Its content.
    pub data: Data,
}

/// The content of a [`Value`].
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// A number written without fraction and exponent that fits 64 bits.
    Integer(i64),
    /// Any other number; finite.
    Number(f64),
    /// A text.
    Text(String),
    /// Values in order.
    List(Vec<Value>),
    /// Named values in order, without duplicate names.
    Object(Vec<Entry>),
}

/// A named value of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its name.
    pub key: String,
    /// The place of the name.
    pub place: Location,
    /// The value.
    pub value: Value,
}

impl Value {
    /// A description for messages: `the text 'abc'`, `a list`.
    pub fn describe(&self) -> String {
        match &self.data {
            Data::Null => "null".to_owned(),
            Data::Bool(value) => value.to_string(),
            Data::Integer(value) => format!("the integer {value}"),
            Data::Number(value) => format!("the number {value}"),
            Data::Text(text) => format!("the text '{}'", shortened(text)),
            Data::List(_) => "a list".to_owned(),
            Data::Object(_) => "an object".to_owned(),
        }
    }

    /// The text, if it is one.
    pub fn as_text(&self) -> Option<&str> {
        match &self.data {
            Data::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The entries, if it is an object.
    pub fn as_object(&self) -> Option<&[Entry]> {
        match &self.data {
            Data::Object(entries) => Some(entries),
            _ => None,
        }
    }

    /// The items, if it is a list.
    pub fn as_list(&self) -> Option<&[Self]> {
        match &self.data {
            Data::List(items) => Some(items),
            _ => None,
        }
    }

    /// The value of `key`, if it is an object that has it.
    pub fn get(&self, key: &str) -> Option<&Self> {
        let entry = self.as_object()?.iter().find(|e| e.key == key)?;
        Some(&entry.value)
    }
}

/// A text from a file in the form for messages: no longer than a line, without
/// control characters, which could change the terminal.
pub fn shortened(text: &str) -> String {
    const KEPT: usize = 60;
    let mut short: String = text
        .chars()
        .take(KEPT)
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    if text.chars().nth(KEPT).is_some() {
        short.push_str("...");
    }
    short
}

/// Reads one JSON value; `file` is the name in messages.
///
/// # Errors
/// The first syntax error, or else all duplicate keys and all numbers out of range.
///
/// ```
/// use behavior::descriptor::json;
/// let wrong = json::parse("a.json", "{\"x\": 1,\n \"x\": 2}").unwrap_err();
/// assert_eq!(
///     wrong.to_string(),
///     "a.json:2:2: key 'x' is given twice, first in line 1; keep one of them"
/// );
/// ```
pub fn parse(file: &str, text: &str) -> Result<Value, Errors> {
    let mut errors = Errors::default();
    if text.len() > MAX_BYTES {
        let message = format!(
            "the file has {} bytes, at most {MAX_BYTES} are allowed; split it",
            text.len()
        );
        errors.push(file, Location::START, message);
        return Err(errors);
    }
    // Editors on other systems add a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let parsed = match parse_to_ast(text, &CollectOptions::default(), &STRICT) {
        Ok(parsed) => parsed,
        Err(error) => {
            let place = Lines::new(text).place(error.range().start);
            let message = match error.kind() {
                ParseErrorKind::NestingDepthExceeded => too_deep(),
                kind => format!("this is not JSON: {}", lower_first(&kind.to_string())),
            };
            errors.push(file, place, message);
            return Err(errors);
        }
    };
    let Some(root) = parsed.value else {
        errors.push(
            file,
            Location::START,
            "the file is empty, a JSON value is needed",
        );
        return Err(errors);
    };
    let mut reader = Reader {
        file,
        lines: Lines::new(text),
        errors,
    };
    let value = reader.value(root, 0);
    reader.errors.or(value)
}

// Extensions of the parser are off: a file with comments would not load in other tools.
const STRICT: ParseOptions = ParseOptions {
    allow_comments: false,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// The message for the parser's own limit, which is beyond ours, and for ours.
fn too_deep() -> String {
    format!(
        "objects and lists are nested deeper than {MAX_DEPTH} levels, two for each node within a \
         node; use subtrees, or fewer levels"
    )
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    let first = chars.next().map(|c| c.to_ascii_lowercase());
    first.into_iter().chain(chars).collect()
}

struct Reader<'a> {
    file: &'a str,
    lines: Lines<'a>,
    errors: Errors,
}

impl Reader<'_> {
    /// The recursion is limited by [`MAX_DEPTH`].
    fn value(&mut self, value: ast::Value<'_>, depth: usize) -> Value {
        use jsonc_parser::common::Ranged;
        let place = self.lines.place(value.start());
        let data = match value {
            ast::Value::NullKeyword(_) => Data::Null,
            ast::Value::BooleanLit(literal) => Data::Bool(literal.value),
            ast::Value::StringLit(literal) => Data::Text(literal.value.into_owned()),
            ast::Value::NumberLit(literal) => self.number(literal.value, place),
            ast::Value::Array(_) | ast::Value::Object(_) if depth >= MAX_DEPTH => {
                self.errors.push(self.file, place, too_deep());
                Data::Null
            }
            ast::Value::Array(list) => {
                let items = list.elements.into_iter();
                Data::List(items.map(|item| self.value(item, depth + 1)).collect())
            }
            ast::Value::Object(object) => self.object(object, depth),
        };
        Value { place, data }
    }

    fn object(&mut self, object: ast::Object<'_>, depth: usize) -> Data {
        let mut seen: BTreeMap<String, Location> = BTreeMap::new();
        let mut entries = Vec::with_capacity(object.properties.len());
        for property in object.properties {
            let place = self.lines.place(property.range.start);
            let key = property.name.into_string();
            let value = self.value(property.value, depth + 1);
            // Many readers of JSON keep the last one without a message.
            if let Some(first) = seen.get(&key) {
                let message = format!(
                    "key '{}' is given twice, first in line {}; keep one of them",
                    shortened(&key),
                    first.line
                );
                self.errors.push(self.file, place, message);
                continue;
            }
            seen.insert(key.clone(), place);
            entries.push(Entry { key, place, value });
        }
        Data::Object(entries)
    }

    fn number(&mut self, text: &str, place: Location) -> Data {
        // Integers first: as a float, a large one would lose digits.
        if let Ok(integer) = text.parse::<i64>() {
            return Data::Integer(integer);
        }
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Data::Number(number),
            _ => {
                let message = format!("{} is not a finite number", shortened(text));
                self.errors.push(self.file, place, message);
                Data::Number(0.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_knows_its_place() {
        let value = parse("f", "{\n  \"a\": [1, 2.5,\n \"ü\", null]}").unwrap();
        let list = value.get("a").unwrap().as_list().unwrap();
        assert_eq!(list[0].data, Data::Integer(1));
        assert_eq!(list[1].data, Data::Number(2.5));
        assert_eq!(list[2].as_text(), Some("ü"));
        assert_eq!(list[2].place, Location { line: 3, column: 2 });
        assert_eq!(list[3].place, Location { line: 3, column: 7 });
    }

    #[test]
    fn depth_is_limited_before_the_stack_is() {
        for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
            let deep = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
            let wrong = parse("f", &deep).unwrap_err().to_string();
            assert!(wrong.contains("deeper than 128"), "{wrong}");
            let deep = format!("{}1{}", open.repeat(200), close.repeat(200));
            let wrong = parse("f", &deep).unwrap_err().to_string();
            assert!(wrong.contains("deeper than 128"), "{wrong}");
        }
    }

    #[test]
    fn all_keys_given_twice_and_numbers_out_of_range_are_named() {
        let wrong = parse("f", "{\"a\": 1e999, \"a\": 2,\n\"b\": -1e999}").unwrap_err();
        assert_eq!(wrong.list.len(), 3);
        assert_eq!(
            wrong.to_string().lines().last(),
            Some("f:2:6: -1e999 is not a finite number")
        );
    }

    #[test]
    fn only_plain_json_is_read() {
        for text in [
            "",
            "{",
            "[1,]",
            "// x\n1",
            "{a: 1}",
            "'a'",
            "+1",
            "NaN",
            "0x10",
            "[1 2]",
            "1 2",
            "Infinity",
            ".5",
            "\"",
            "\"\\x41\"",
        ] {
            let wrong = parse("f", text).unwrap_err().to_string();
            assert!(
                wrong.starts_with("f:1:") || wrong.starts_with("f:2:"),
                "{wrong}"
            );
        }
        assert!(parse("f", &" ".repeat(MAX_BYTES + 1)).is_err());
        assert_eq!(parse("f", "\u{feff}1").unwrap().data, Data::Integer(1));
    }
}
