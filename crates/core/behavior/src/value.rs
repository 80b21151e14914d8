//! Values of ports and blackboard keys: small, copied, without heap memory.

use serde::{Deserialize, Serialize};

/// Largest length of a [`Str`] (bytes).
// A value has a fixed size and is copied: boards and checkpoints need no heap.
pub const STR_BYTES: usize = 62;
/// Largest number of items of a [`Numbers`].
// A pose has seven numbers, as has a configuration of an arm with seven axes.
pub const MAX_NUMBERS: usize = 8;

/// A short text.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Str {
    len: u8,
    bytes: [u8; STR_BYTES],
}

impl Str {
    /// The empty text.
    pub const EMPTY: Self = Self {
        len: 0,
        bytes: [0; STR_BYTES],
    };

    /// `text`, or `None` if it is longer than [`STR_BYTES`].
    pub fn new(text: &str) -> Option<Self> {
        let mut bytes = [0; STR_BYTES];
        bytes
            .get_mut(..text.len())?
            .copy_from_slice(text.as_bytes());
        Some(Self {
            len: u8::try_from(text.len()).ok()?,
            bytes,
        })
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        let written = self.bytes.get(..usize::from(self.len)).unwrap_or_default();
        std::str::from_utf8(written).unwrap_or_default()
    }

    /// Whether it is the empty text.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

impl Default for Str {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl std::fmt::Debug for Str {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        std::fmt::Debug::fmt(self.as_str(), f)
    }
}

impl std::fmt::Display for Str {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

impl Serialize for Str {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for Str {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Str;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "a text of at most {STR_BYTES} bytes")
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Str, E> {
                Str::new(text).ok_or_else(|| E::invalid_length(text.len(), &self))
            }
        }
        deserializer.deserialize_str(Visitor)
    }
}

/// A few numbers: a position, a pose, a configuration.
#[derive(Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Numbers {
    len: u8,
    values: [f64; MAX_NUMBERS],
}

impl Numbers {
    /// `values`, or `None` if there are more than [`MAX_NUMBERS`].
    pub fn new(values: &[f64]) -> Option<Self> {
        let mut all = [0.0; MAX_NUMBERS];
        all.get_mut(..values.len())?.copy_from_slice(values);
        Some(Self {
            len: u8::try_from(values.len()).ok()?,
            values: all,
        })
    }

    /// The numbers.
    pub fn as_slice(&self) -> &[f64] {
        self.values
            .get(..usize::from(self.len))
            .unwrap_or(&self.values)
    }
}

impl std::fmt::Debug for Numbers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        std::fmt::Debug::fmt(self.as_slice(), f)
    }
}

/// A set of numbers from 0 to 63: adding a member again changes nothing.
#[derive(Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Set(pub u64);

impl Set {
    /// Whether `item` is in it.
    pub fn contains(self, item: u32) -> bool {
        item < u64::BITS && self.0 >> item & 1 == 1
    }

    /// With `item`; unchanged for one beyond 63.
    pub fn with(self, item: u32) -> Self {
        Self(self.0 | 1_u64.checked_shl(item).unwrap_or(0))
    }

    /// Without `item`.
    pub fn without(self, item: u32) -> Self {
        Self(self.0 & !1_u64.checked_shl(item).unwrap_or(0))
    }

    /// Number of members.
    pub fn len(self) -> u32 {
        self.0.count_ones()
    }

    /// Whether it has no members.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// All members, in ascending order.
    pub fn items(self) -> impl Iterator<Item = u32> {
        (0..u64::BITS).filter(move |item| self.contains(*item))
    }
}

impl std::fmt::Debug for Set {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.items()).finish()
    }
}

/// Type of a [`Value`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ValueType {
    /// `true` or `false`.
    Bool,
    /// A whole number.
    Integer,
    /// A finite number.
    Number,
    /// A short text.
    Text,
    /// Up to eight finite numbers.
    Numbers,
    /// A set of numbers from 0 to 63.
    Set,
}

impl ValueType {
    /// Name in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Integer => "integer",
            Self::Number => "number",
            Self::Text => "text",
            Self::Numbers => "numbers",
            Self::Set => "set",
        }
    }
}

/// Value of a port or of a blackboard key.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// See [`ValueType::Bool`].
    Bool(bool),
    /// See [`ValueType::Integer`].
    Integer(i64),
    /// See [`ValueType::Number`].
    Number(f64),
    /// See [`ValueType::Text`].
    Text(Str),
    /// See [`ValueType::Numbers`].
    Numbers(Numbers),
    /// See [`ValueType::Set`].
    Set(Set),
}

impl Value {
    /// Its type.
    pub fn value_type(&self) -> ValueType {
        match self {
            Self::Bool(_) => ValueType::Bool,
            Self::Integer(_) => ValueType::Integer,
            Self::Number(_) => ValueType::Number,
            Self::Text(_) => ValueType::Text,
            Self::Numbers(_) => ValueType::Numbers,
            Self::Set(_) => ValueType::Set,
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bool(value) => write!(f, "{value}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Number(value) => write!(f, "{value}"),
            Self::Text(value) => write!(f, "'{value}'"),
            Self::Numbers(value) => write!(f, "{value:?}"),
            Self::Set(value) => write!(f, "{value:?}"),
        }
    }
}

/// A Rust type that a [`Value`] can hold.
pub trait Plain: Copy + 'static {
    /// The value's type.
    const TYPE: ValueType;

    /// `None` for a value of another type, or of another length.
    fn from_value(value: Value) -> Option<Self>;

    /// As a value.
    fn into_value(self) -> Value;
}

macro_rules! plain {
    ($type:ty, $variant:ident) => {
        impl Plain for $type {
            const TYPE: ValueType = ValueType::$variant;

            fn from_value(value: Value) -> Option<Self> {
                match value {
                    Value::$variant(value) => Some(value),
                    _ => None,
                }
            }

            fn into_value(self) -> Value {
                Value::$variant(self)
            }
        }
    };
}

plain!(bool, Bool);
plain!(i64, Integer);
plain!(f64, Number);
plain!(Str, Text);
plain!(Numbers, Numbers);
plain!(Set, Set);

impl<const N: usize> Plain for [f64; N] {
    const TYPE: ValueType = ValueType::Numbers;

    fn from_value(value: Value) -> Option<Self> {
        Numbers::from_value(value)?.as_slice().try_into().ok()
    }

    fn into_value(self) -> Value {
        // Longer arrays are cut; the ports of a node are checked once,
        // when it is loaded.
        let kept = self.get(..N.min(MAX_NUMBERS)).unwrap_or_default();
        Value::Numbers(Numbers::new(kept).unwrap_or_default())
    }
}
