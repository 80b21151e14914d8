//! TOML and JSON as one kind of value with places.

use toml::de::{DeTable, DeValue};

use crate::descriptor::json::{self, Data, Entry, MAX_BYTES, Value, shortened};
use crate::lines::Lines;
use crate::machine::problem::{Collector, Location, Problem, Problems};

/// Nesting of TOML that the parser reads, for its message.
// The limit of the parser itself, which its message does not name.
const LEVELS: usize = 80;

/// Reads `text` as JSON if the name of the file ends with `.json`, otherwise as TOML.
pub(crate) fn parse(file: &str, text: &str) -> Result<Value, Problems> {
    let name = std::path::Path::new(file);
    let is_json = name
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    if is_json {
        return json::parse(file, text).map_err(|errors| {
            let list = errors.list.into_iter().map(|it| Problem {
                place: Location {
                    line: it.line,
                    column: it.column,
                },
                message: it.message,
            });
            Problems::new(file, list.collect())
        });
    }
    parse_toml(file, text)
}

fn parse_toml(file: &str, text: &str) -> Result<Value, Problems> {
    let mut problems = Collector::default();
    // Before parsing, which needs memory for a multiple of the text.
    if text.len() > MAX_BYTES {
        let message = format!("the file has more than {MAX_BYTES} bytes; split it");
        problems.add(Location { line: 1, column: 1 }, message);
        return problems.finish(file, null());
    }
    let lines = Lines::new(text);
    // The parser continues after a mistake, so that all are reported at once.
    let (table, errors) = DeTable::parse_recoverable(text);
    for error in &errors {
        let offset = error.span().map_or(0, |span| span.start);
        let message = match error.message() {
            // The parser's own message for its own limit.
            deep if deep.contains("recursion depth") => {
                format!("tables and lists are nested deeper than {LEVELS} levels; use fewer")
            }
            other => format!("this is not TOML: {}", other.trim().replace('\n', "; ")),
        };
        problems.add(lines.place(offset).into(), message);
    }
    if !errors.is_empty() {
        return problems.finish(file, null());
    }
    let mut reader = Reader { lines, problems };
    let data = reader.table(table.get_ref());
    let place = json::Location::START;
    reader.problems.finish(file, Value { place, data })
}

fn null() -> Value {
    Value {
        place: json::Location::START,
        data: Data::Null,
    }
}

struct Reader<'a> {
    lines: Lines<'a>,
    problems: Collector,
}

impl Reader<'_> {
    /// The parser limits the depth of `value`, so this recursion is bounded.
    fn value(&mut self, value: &toml::Spanned<DeValue<'_>>) -> Value {
        let place = self.lines.place(value.span().start);
        let data = match value.get_ref() {
            DeValue::String(text) => Data::Text(text.to_string()),
            DeValue::Boolean(flag) => Data::Bool(*flag),
            DeValue::Integer(number) => {
                let parsed = i64::from_str_radix(number.as_str(), number.radix());
                parsed.map_or_else(|_| self.no_number(place, number.as_str()), Data::Integer)
            }
            DeValue::Float(number) => match number.as_str().parse::<f64>() {
                Ok(number) if number.is_finite() => Data::Number(number),
                _ => self.no_number(place, number.as_str()),
            },
            // No key takes a date; as a text it gets the message of that key.
            DeValue::Datetime(date) => Data::Text(date.to_string()),
            DeValue::Array(items) => Data::List(items.iter().map(|it| self.value(it)).collect()),
            DeValue::Table(table) => self.table(table),
        };
        Value { place, data }
    }

    fn table(&mut self, table: &DeTable<'_>) -> Data {
        let mut entries: Vec<Entry> = Vec::with_capacity(table.len());
        for (key, value) in table {
            entries.push(Entry {
                key: key.get_ref().to_string(),
                place: self.lines.place(key.span().start),
                value: self.value(value),
            });
        }
        // The parser sorts keys by name; here they keep the order of the file.
        entries.sort_by_key(|entry| entry.place);
        Data::Object(entries)
    }

    fn no_number(&mut self, place: json::Location, text: &str) -> Data {
        let message = format!("{} is not a number of 64 bits", shortened(text));
        self.problems.add(place.into(), message);
        Data::Null
    }
}
