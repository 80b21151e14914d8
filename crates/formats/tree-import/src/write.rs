//! JSON with the order and the line breaks that people expect.

use serde_json::Value;

/// Column beyond which an object or list is broken into lines.
const WIDTH: usize = 96;

/// JSON whose objects keep their order.
#[derive(Clone, Debug)]
pub(crate) enum Json {
    Value(Value),
    List(Vec<Json>),
    Object(Vec<(String, Json)>),
}

impl<T: Into<Value>> From<T> for Json {
    fn from(value: T) -> Self {
        Self::Value(value.into())
    }
}

/// The text of a value.
pub(crate) fn text(json: &Json) -> String {
    let mut text = String::new();
    write(json, 0, &mut text);
    text.push('\n');
    text
}

fn write(json: &Json, indent: usize, text: &mut String) {
    let line = one_line(json);
    if indent + line.len() <= WIDTH {
        return text.push_str(&line);
    }
    let inner = indent + 2;
    let line_break = |text: &mut String, index: usize| {
        text.push_str(if index > 0 { ",\n" } else { "\n" });
        text.push_str(&" ".repeat(inner));
    };
    let close = match json {
        Json::Value(_) => return text.push_str(&line),
        Json::List(items) => {
            text.push('[');
            for (index, item) in items.iter().enumerate() {
                line_break(text, index);
                write(item, inner, text);
            }
            ']'
        }
        Json::Object(entries) => {
            text.push('{');
            // The first entries, id and type, are on the first line, as they are short.
            let mut rest = entries.as_slice();
            while let [(key, value @ Json::Value(_)), after @ ..] = rest {
                if rest.len() < entries.len() {
                    text.push_str(", ");
                }
                text.push_str(&quoted(key));
                text.push_str(": ");
                text.push_str(&one_line(value));
                rest = after;
                if key == "type" || key == "format" {
                    break;
                }
            }
            let begun = rest.len() < entries.len();
            for (index, (key, value)) in rest.iter().enumerate() {
                line_break(text, usize::from(begun) + index);
                text.push_str(&quoted(key));
                text.push_str(": ");
                write(value, inner, text);
            }
            '}'
        }
    };
    text.push('\n');
    text.push_str(&" ".repeat(indent));
    text.push(close);
}

fn one_line(json: &Json) -> String {
    match json {
        Json::Value(value) => value.to_string(),
        Json::List(items) => {
            let items: Vec<String> = items.iter().map(one_line).collect();
            format!("[{}]", items.join(", "))
        }
        Json::Object(entries) => {
            let entries = entries.iter();
            let entries =
                entries.map(|(key, value)| format!("{}: {}", quoted(key), one_line(value)));
            format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
        }
    }
}

fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}
