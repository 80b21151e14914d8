//! Messages to and from a policy server: `MessagePack` maps with arrays as `NumPy` has them.
//!
//! There are two conventions, of openpi and of vla-eval. Keys of an array are byte strings with the
//! first and text with the second; both are read from either.

mod count;
mod quote;

use rmpv::Value;
use rmpv::decode::read_value_with_max_depth;

use quote::Tail;

/// Deepest nesting of an answer that is read.
const DEPTH: usize = 32;

/// Largest number of values of an answer: stored they need 40 bytes each, and one byte in the
/// message. An array of `NumPy` is one value for all of its numbers.
const MAX_VALUES: u64 = 100_000;

/// Largest number of rows of an answer: a checkpoint has all of them.
const MAX_ROWS: usize = 1000;

/// Largest number of numbers of a row; an arm has at most 8.
const MAX_WIDTH: usize = 64;

/// Longest part of a server's own message that is repeated (characters).
const QUOTED: usize = 300;

/// The convention of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convention {
    /// The server speaks first; then one map each way.
    OpenPi,
    /// Each message has a type, a payload and a number; the client speaks first.
    VlaEval,
}

/// One observation.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Numbers.
    Numbers(Vec<f32>),
    /// A picture: height, width, and red, green and blue of each pixel.
    Picture(u32, u32, Vec<u8>),
    /// Text.
    Text(String),
}

/// Observations by their keys.
pub type Observations = Vec<(String, Content)>;

/// Rows of actions, each of the same length, at least one.
pub type Rows = Vec<Vec<f32>>;

/// Why a message of a server has no actions.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AnswerError {
    /// The server reports an error.
    #[error("the server reports an error: {0}")]
    Reported(String),
    /// Not a message of this convention.
    #[error("{0}")]
    Invalid(String),
}

fn invalid(why: impl Into<String>) -> AnswerError {
    AnswerError::Invalid(why.into())
}

/// A request of `observations`.
pub fn request(convention: Convention, number: u64, observations: &Observations) -> Vec<u8> {
    match convention {
        Convention::OpenPi => {
            let entry = |(key, content): &(String, Content)| {
                (Value::from(key.as_str()), value(convention, content))
            };
            bytes(&Value::Map(observations.iter().map(entry).collect()))
        }
        Convention::VlaEval => message("observation", number, nested(observations)),
    }
}

/// A message of vla-eval without observations.
pub fn note(kind: &str, number: u64, entries: &[(&str, &str)]) -> Vec<u8> {
    let entries = entries
        .iter()
        .map(|(key, text)| (Value::from(*key), Value::from(*text)));
    message(kind, number, Value::Map(entries.collect()))
}

fn message(kind: &str, number: u64, payload: Value) -> Vec<u8> {
    bytes(&Value::Map(vec![
        (Value::from("type"), Value::from(kind)),
        (Value::from("payload"), payload),
        (Value::from("seq"), Value::from(number)),
        // The wall clock would make the bytes of equal requests differ.
        (Value::from("timestamp"), Value::F64(0.0)),
    ]))
}

/// Observations of which `GROUP/NAME` is the entry `NAME` of the map `GROUP`.
fn nested(observations: &Observations) -> Value {
    let mut map: Vec<(Value, Value)> = Vec::new();
    for (key, content) in observations {
        let content = value(Convention::VlaEval, content);
        let Some((group, name)) = key.split_once('/') else {
            map.push((Value::from(key.as_str()), content));
            continue;
        };
        let entry = (Value::from(name), content);
        let found = map.iter_mut().find(|(key, _)| key.as_str() == Some(group));
        match found {
            Some((_, Value::Map(entries))) => entries.push(entry),
            _ => map.push((Value::from(group), Value::Map(vec![entry]))),
        }
    }
    Value::Map(map)
}

fn value(convention: Convention, content: &Content) -> Value {
    match content {
        Content::Text(text) => Value::from(text.as_str()),
        Content::Numbers(numbers) => {
            let data = numbers.iter().flat_map(|number| number.to_le_bytes());
            array(convention, data.collect(), "<f4", &[numbers.len() as u64])
        }
        Content::Picture(height, width, rgb) => {
            let shape = [u64::from(*height), u64::from(*width), 3];
            array(convention, rgb.clone(), "|u1", &shape)
        }
    }
}

fn array(convention: Convention, data: Vec<u8>, kind: &str, shape: &[u64]) -> Value {
    let key = |name: &str| match convention {
        Convention::OpenPi => Value::Binary(name.as_bytes().to_vec()),
        Convention::VlaEval => Value::from(name),
    };
    let shape = shape.iter().map(|side| Value::from(*side));
    Value::Map(vec![
        (key("__ndarray__"), Value::Boolean(true)),
        (key("data"), Value::Binary(data)),
        (key("dtype"), Value::from(kind)),
        (key("shape"), Value::Array(shape.collect())),
    ])
}

fn bytes(value: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Writing to memory cannot fail.
    rmpv::encode::write_value(&mut bytes, value).ok();
    bytes
}

/// Whether the first message of a server is one of vla-eval.
pub fn is_hello(bytes: &[u8]) -> bool {
    read(bytes).is_ok_and(|map| kind_of(&map) == Some("hello"))
}

/// The actions in an answer.
///
/// # Errors
/// For bytes that are not an answer of this convention, or an array of another shape or kind.
pub fn actions(convention: Convention, bytes: &[u8]) -> Result<Rows, AnswerError> {
    let map = read(bytes)?;
    let payload = match convention {
        Convention::OpenPi => &map,
        Convention::VlaEval => payload(&map)?,
    };
    let found = entry(payload, "actions");
    let found =
        found.ok_or_else(|| invalid(format!("it has no \"actions\"; {}", keys(payload))))?;
    let rows = rows(found)?;
    let width = rows.first().map_or(0, Vec::len);
    check_size(rows.len() as u64, width as u64)?;
    if width == 0 || rows.iter().any(|row| row.len() != width) {
        return Err(invalid(
            "\"actions\" is empty, or has rows of several lengths",
        ));
    }
    match rows.iter().flatten().find(|number| !number.is_finite()) {
        Some(number) => Err(invalid(format!(
            "\"actions\" has {number}; finite numbers are needed"
        ))),
        None => Ok(rows),
    }
}

/// Refuses an array that is too large, by its shape: rows are stored one by one.
fn check_size(rows: u64, width: u64) -> Result<(), AnswerError> {
    let refused = |why| Err(invalid(format!("\"actions\" has {why} are read")));
    if rows > MAX_ROWS as u64 {
        return refused(format!("{rows} rows; at most {MAX_ROWS}"));
    }
    if width > MAX_WIDTH as u64 {
        return refused(format!("rows of {width} numbers; at most {MAX_WIDTH}"));
    }
    Ok(())
}

fn read(mut bytes: &[u8]) -> Result<Value, AnswerError> {
    if !count::has_at_most(MAX_VALUES, bytes) {
        return Err(invalid(format!(
            "it has more than {MAX_VALUES} values; an array of NumPy counts as one for all of its numbers"
        )));
    }
    let value = read_value_with_max_depth(&mut bytes, DEPTH)
        .map_err(|error| invalid(format!("it is not MessagePack: {error}")))?;
    match value {
        Value::Map(_) => Ok(value),
        _ => Err(invalid("it is not a map")),
    }
}

fn payload(map: &Value) -> Result<&Value, AnswerError> {
    let payload = entry(map, "payload");
    match (kind_of(map), payload) {
        (Some("action"), Some(payload)) => Ok(payload),
        (Some("error"), payload) => {
            let text = payload.map_or_else(String::new, |payload| Tail::of([payload]));
            Err(AnswerError::Reported(quoted(&text)))
        }
        (kind, _) => Err(invalid(format!(
            "its type is {:?}; \"action\" with a payload is expected",
            kind.unwrap_or_default()
        ))),
    }
}

/// The end of a message of a server: of a stack trace it says most.
pub fn quoted(text: &str) -> String {
    let text = text.trim();
    let skipped = text.chars().count().saturating_sub(QUOTED);
    text.chars()
        .skip(skipped)
        .collect::<String>()
        .replace('\n', "; ")
}

fn kind_of(map: &Value) -> Option<&str> {
    entry(map, "type")?.as_str()
}

/// The value of a key, which is text or a byte string.
fn entry<'a>(map: &'a Value, key: &str) -> Option<&'a Value> {
    let is_key = |known: &Value| match known {
        Value::Binary(bytes) => bytes == key.as_bytes(),
        known => known.as_str() == Some(key),
    };
    let entries = map.as_map()?.iter();
    entries
        .into_iter()
        .find(|(known, _)| is_key(known))
        .map(|(_, value)| value)
}

fn keys(map: &Value) -> String {
    let keys = map.as_map().into_iter().flatten();
    quoted(&format!(
        "its keys are {}",
        Tail::of(keys.take(20).map(|(key, _)| key))
    ))
}

/// A `NumPy` array of one or two dimensions, or lists of numbers.
fn rows(value: &Value) -> Result<Rows, AnswerError> {
    if entry(value, "__ndarray__").is_some() {
        return numpy(value);
    }
    let Some(list) = value.as_array() else {
        return Err(invalid("\"actions\" is neither an array nor a list"));
    };
    let number = |value: &Value| value.as_f64().map(single);
    let row = |values: &[Value]| values.iter().map(number).collect::<Option<Vec<f32>>>();
    let rows = if list.iter().all(|value| value.as_f64().is_some()) {
        row(list).map(|row| vec![row])
    } else {
        list.iter().map(|value| row(value.as_array()?)).collect()
    };
    rows.ok_or_else(|| invalid("\"actions\" has values that are no numbers"))
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "actions are numbers of 32 bits"
)]
fn single(number: f64) -> f32 {
    number as f32
}

fn numpy(value: &Value) -> Result<Rows, AnswerError> {
    let data = entry(value, "data").and_then(Value::as_slice);
    let kind = entry(value, "dtype").and_then(text_of);
    let shape = entry(value, "shape").and_then(Value::as_array);
    let shape = shape.and_then(|sides| {
        sides
            .iter()
            .map(Value::as_u64)
            .collect::<Option<Vec<u64>>>()
    });
    let (Some(data), Some(kind), Some(shape)) = (data, kind, shape) else {
        return Err(invalid(
            "\"actions\" is an array without data, dtype or shape",
        ));
    };
    let size = size_of(kind)?;
    let (rows, width) = match shape.as_slice() {
        [width] => (1, *width),
        [rows, width] => (*rows, *width),
        _ => {
            return Err(invalid(format!(
                "\"actions\" has the shape {shape:?}; 2 dimensions are needed"
            )));
        }
    };
    // The length is checked before anything is read: shapes are products that may overflow.
    let numbers = shape
        .iter()
        .try_fold(size as u64, |all, side| all.checked_mul(*side));
    if numbers != Some(data.len() as u64) || width == 0 {
        let length = data.len();
        return Err(invalid(format!(
            "\"actions\" has the shape {shape:?} and {length} bytes"
        )));
    }
    check_size(rows, width)?;
    let numbers: Vec<f32> = match size {
        4 => data
            .as_chunks::<4>()
            .0
            .iter()
            .map(|bytes| f32::from_le_bytes(*bytes))
            .collect(),
        _ => data
            .as_chunks::<8>()
            .0
            .iter()
            .map(|bytes| single(f64::from_le_bytes(*bytes)))
            .collect(),
    };
    let width = usize::try_from(width).unwrap_or(usize::MAX);
    Ok(numbers.chunks(width).map(<[f32]>::to_vec).collect())
}

/// Bytes of a number of this dtype.
fn size_of(kind: &str) -> Result<usize, AnswerError> {
    match kind {
        "<f4" | "float32" => Ok(4),
        "<f8" | "float64" => Ok(8),
        _ => {
            let allowed = "float32 and float64 are allowed";
            Err(invalid(format!(
                "\"actions\" has the dtype {kind:?}; {allowed}"
            )))
        }
    }
}

/// Text, also as a byte string.
fn text_of(value: &Value) -> Option<&str> {
    match value {
        Value::Binary(bytes) => std::str::from_utf8(bytes).ok(),
        value => value.as_str(),
    }
}
