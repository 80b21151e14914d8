//! Defines messages: no padding, no pointer, a schema hash in the type name.
//!
//! What can go wrong: two programs of different builds share memory and agree on the size of a
//! message but not on its meaning. The transport compares name, size and alignment only, so two
//! structs with swapped fields connect without an error. The rule: the type name carries a hash
//! of all field names, types and offsets. A change must not break: `zeroed` and every bit
//! pattern is valid, so no `bool`, no enum, no reference in a message; codes are validated.

use crate::layout::StructLayout;

/// Plain data that can be in memory shared between processes.
///
/// # Safety
///
/// The type is `repr(C)`, has no padding, no pointer and no value that depends
/// on the process that reads it, and every bit pattern is a valid value of it.
/// The `wire!` macro proves the first two at compile time.
pub unsafe trait Wire: Copy + Send + Sync + 'static {
    /// Hash of the names, offsets and types of all fields, recursively.
    const SCHEMA: u64;

    /// Calls `visit` with name and byte offset of every `f64` in the type, which is called
    /// `name` and starts at `offset`. For tests that damage messages.
    fn each_float(_name: &str, _offset: usize, _visit: &mut dyn FnMut(&str, usize)) {}

    /// Name of the type of one element, and how many there are: 1 for all but arrays.
    fn element() -> (String, usize);

    /// Appends the layout of the struct, and of every struct in it, unless `into` has it.
    /// Numbers and text have none.
    fn describe(_into: &mut Vec<StructLayout>) {}

    /// The message of all zeros, which is a valid value of every [`Wire`] type.
    fn zeroed() -> Self {
        // SAFETY: every bit pattern is a valid value (contract of the trait).
        unsafe { core::mem::zeroed() }
    }

    /// The bytes of the message, in the order of the machine.
    fn as_bytes(&self) -> &[u8] {
        // SAFETY: no padding (contract of the trait), so every byte is
        // initialised; the slice lives as long as the borrow of `self`.
        unsafe { core::slice::from_raw_parts((&raw const *self).cast::<u8>(), size_of::<Self>()) }
    }

    /// The message those bytes are; `None` when there are more or fewer.
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        // Exactly: a longer message of a newer version must not be read as one of this version.
        if bytes.len() != size_of::<Self>() {
            return None;
        }
        // SAFETY: the length was checked, the read needs no alignment, and every
        // bit pattern is a valid value (contract of the trait).
        Some(unsafe { bytes.as_ptr().cast::<Self>().read_unaligned() })
    }
}

/// The layout of `T`, first, and of every struct in it.
pub fn layout_of<T: Wire>() -> Vec<StructLayout> {
    let mut structs = Vec::new();
    T::describe(&mut structs);
    structs
}

// FNV-1a, as it can be computed in a constant: the hash is known when the program is compiled.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

/// FNV-1a over the bytes of `text`, starting from `hash`.
pub(crate) const fn hash_str(mut hash: u64, text: &str) -> u64 {
    let bytes = text.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(FNV_PRIME);
        i += 1;
    }
    hash
}

/// FNV-1a over the little-endian bytes of `value`, starting from `hash`.
pub(crate) const fn hash_u64(mut hash: u64, value: u64) -> u64 {
    let bytes = value.to_le_bytes();
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(FNV_PRIME);
        i += 1;
    }
    hash
}

/// Start value of a schema hash.
// The name takes part, so that two structs with equal fields are different messages.
pub(crate) const fn hash_start(name: &str) -> u64 {
    hash_str(FNV_OFFSET, name)
}

/// Bytes of a type name with its schema hash: `NAME#0123456789abcdef`.
#[cfg(feature = "iceoryx2")]
pub(crate) const fn type_name_bytes<const N: usize>(name: &str, schema: u64) -> [u8; N] {
    let digits = b"0123456789abcdef";
    let mut out = [0u8; N];
    let bytes = name.as_bytes();
    let mut i = 0;
    while i < bytes.len() {
        out[i] = bytes[i];
        i += 1;
    }
    // The `#` separates name and hash, also in the message of a version error.
    out[i] = b'#';
    let mut d = 0;
    while d < 16 {
        out[i + 1 + d] = digits[((schema >> (60 - 4 * d)) & 15) as usize];
        d += 1;
    }
    out
}

macro_rules! primitive {
    ($($t:ty),*) => {$(
        // SAFETY: a number has no padding and no invalid bit pattern.
        unsafe impl Wire for $t {
            const SCHEMA: u64 = hash_start(stringify!($t));

            fn element() -> (String, usize) {
                (stringify!($t).to_owned(), 1)
            }
        }
    )*};
}
primitive!(u8, u32, u64, i64);

// SAFETY: a number has no padding and no invalid bit pattern.
unsafe impl Wire for f64 {
    const SCHEMA: u64 = hash_start("f64");

    fn element() -> (String, usize) {
        ("f64".to_owned(), 1)
    }

    fn each_float(name: &str, offset: usize, visit: &mut dyn FnMut(&str, usize)) {
        visit(name, offset);
    }
}

// SAFETY: an array has no padding of its own.
unsafe impl<T: Wire, const N: usize> Wire for [T; N] {
    const SCHEMA: u64 = hash_u64(hash_u64(hash_start("array"), T::SCHEMA), N as u64);

    fn element() -> (String, usize) {
        let (name, count) = T::element();
        (name, count * N)
    }

    fn describe(into: &mut Vec<StructLayout>) {
        T::describe(into);
    }

    fn each_float(name: &str, offset: usize, visit: &mut dyn FnMut(&str, usize)) {
        for index in 0..N {
            T::each_float(
                &format!("{name}[{index}]"),
                offset + index * size_of::<T>(),
                visit,
            );
        }
    }
}

/// Declares a `repr(C)` struct as [`Wire`] data, and as a message that iceoryx2
/// accepts under a type name that carries the schema hash: another version is
/// refused when a port is opened, not read as garbage.
macro_rules! wire {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$fmeta:meta])* pub $field:ident: $ty:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name { $($(#[$fmeta])* pub $field: $ty,)* }

        const _: () = {
            // Padding would be uninitialised memory, which may not be read as bytes or sent.
            let fields = 0 $(+ size_of::<$ty>())*;
            assert!(fields == size_of::<$name>(), concat!(stringify!($name), " has padding"));
            assert!(align_of::<$name>() <= 8);
        };

        // SAFETY: repr(C), all fields are Wire, and the sizes of the fields add
        // up to the size of the struct, so there is no padding.
        unsafe impl $crate::wire::Wire for $name {
            const SCHEMA: u64 = {
                let mut hash = $crate::wire::hash_start(stringify!($name));
                $(
                    // Name, type and offset of each field: a swap or a
                    // renamed unit changes the hash.
                    hash = $crate::wire::hash_str(hash, stringify!($field));
                    hash = $crate::wire::hash_u64(hash, <$ty as $crate::wire::Wire>::SCHEMA);
                    hash = $crate::wire::hash_u64(hash, core::mem::offset_of!($name, $field) as u64);
                )*
                $crate::wire::hash_u64(hash, size_of::<$name>() as u64)
            };

            fn element() -> (String, usize) {
                (stringify!($name).to_owned(), 1)
            }

            fn describe(into: &mut Vec<$crate::layout::StructLayout>) {
                // A struct used by several fields is described once.
                if into.iter().any(|known| known.name == stringify!($name)) {
                    return;
                }
                into.push($crate::layout::StructLayout {
                    name: stringify!($name),
                    bytes: size_of::<$name>(),
                    schema: <Self as $crate::wire::Wire>::SCHEMA,
                    fields: vec![$($crate::layout::FieldLayout::new(
                        stringify!($field),
                        <$ty as $crate::wire::Wire>::element(),
                        core::mem::offset_of!($name, $field),
                    ),)*],
                });
                $(<$ty as $crate::wire::Wire>::describe(into);)*
            }

            fn each_float(name: &str, offset: usize, visit: &mut dyn FnMut(&str, usize)) {
                $(
                    <$ty as $crate::wire::Wire>::each_float(
                        &format!("{name}.{}", stringify!($field)),
                        offset + core::mem::offset_of!($name, $field),
                        visit,
                    );
                )*
            }
        }

        // SAFETY: Wire data has no pointer and no resource; it means the same in
        // every process.
        #[cfg(feature = "iceoryx2")]
        unsafe impl iceoryx2::prelude::ZeroCopySend for $name {
            unsafe fn type_name() -> &'static str {
                const N: usize = stringify!($name).len() + 17;
                const BYTES: [u8; N] = $crate::wire::type_name_bytes::<N>(
                    stringify!($name),
                    <$name as $crate::wire::Wire>::SCHEMA,
                );
                const TEXT: &str = match core::str::from_utf8(&BYTES) {
                    Ok(text) => text,
                    Err(_) => panic!("type names are ASCII"),
                };
                TEXT
            }
        }
    };
}
pub(crate) use wire;

#[cfg(test)]
#[allow(unreachable_pub, reason = "the macro declares what others see")]
mod tests {
    use super::*;

    wire! {
        /// Two numbers.
        pub struct Sample { pub a: u64, pub b: f64, }
    }
    mod swapped {
        wire! {
            /// The same size, other meaning.
            pub struct Sample { pub a: f64, pub b: u64, }
        }
        wire! {
            /// The same types under other names.
            pub struct Renamed { pub b: u64, pub a: f64, }
        }
    }

    #[test]
    fn a_change_of_types_or_names_changes_the_schema() {
        assert_ne!(Sample::SCHEMA, swapped::Sample::SCHEMA);
        assert_ne!(Sample::SCHEMA, swapped::Renamed::SCHEMA);
    }

    #[test]
    fn bytes_go_there_and_back() {
        let sample = Sample { a: 7, b: -0.5 };
        assert_eq!(Sample::from_bytes(sample.as_bytes()), Some(sample));
        assert_eq!(Sample::from_bytes(&sample.as_bytes()[1..]), None);
    }

    #[cfg(feature = "iceoryx2")]
    #[test]
    fn the_type_name_carries_the_schema() {
        use iceoryx2::prelude::ZeroCopySend;
        // SAFETY: the function only returns a constant.
        let name = unsafe { Sample::type_name() };
        assert_eq!(name, format!("Sample#{:016x}", Sample::SCHEMA));
    }
}
