//! The number of values in a `MessagePack` message, counted before one of them is stored.

/// Whether the value at the start of `bytes` consists of at most `most` values, itself and all
/// nested ones. A message that is cut or has unknown markers is left to its reader.
// A stored value has forty times the size of the byte that it may have in the message.
pub(super) fn has_at_most(most: u64, bytes: &[u8]) -> bool {
    let (mut rest, mut counted, mut open) = (bytes, 0_u64, 1_u64);
    while open > 0 {
        // Also the elements that an array announces: its reader may make room for them.
        if counted.saturating_add(open) > most {
            return false;
        }
        let Some((skipped, nested, after)) = head(rest) else {
            return true;
        };
        let Some(after) = after.get(usize::try_from(skipped).unwrap_or(usize::MAX)..) else {
            return true;
        };
        (rest, counted, open) = (after, counted + 1, open - 1 + nested);
    }
    true
}

/// Of a value: bytes of its content, values nested in it, and what follows its head.
fn head(bytes: &[u8]) -> Option<(u64, u64, &[u8])> {
    let (&marker, rest) = bytes.split_first()?;
    let low = |mask: u8| u64::from(marker & mask);
    Some(match marker {
        0x80..=0x8f => (0, 2 * low(0x0f), rest),
        0x90..=0x9f => (0, low(0x0f), rest),
        0xa0..=0xbf => (low(0x1f), 0, rest),
        // Binary data and text, with a length of 1, 2 or 4 bytes.
        0xc4..=0xc6 => content(rest, 1 << (marker - 0xc4), 0)?,
        0xd9..=0xdb => content(rest, 1 << (marker - 0xd9), 0)?,
        // Extensions have one byte more, for their type.
        0xc7..=0xc9 => content(rest, 1 << (marker - 0xc7), 1)?,
        0xd4..=0xd8 => (1 + (1 << (marker - 0xd4)), 0, rest),
        // Numbers.
        0xca | 0xce | 0xd2 => (4, 0, rest),
        0xcb | 0xcf | 0xd3 => (8, 0, rest),
        0xcc | 0xd0 => (1, 0, rest),
        0xcd | 0xd1 => (2, 0, rest),
        // Arrays and maps, with a count of 2 or 4 bytes.
        0xdc | 0xdd => nested(rest, 2 << (marker - 0xdc), 1)?,
        0xde | 0xdf => nested(rest, 2 << (marker - 0xde), 2)?,
        // Small numbers, nil, booleans.
        _ => (0, 0, rest),
    })
}

fn content(bytes: &[u8], width: usize, more: u64) -> Option<(u64, u64, &[u8])> {
    let (length, rest) = number(bytes, width)?;
    Some((length + more, 0, rest))
}

fn nested(bytes: &[u8], width: usize, each: u64) -> Option<(u64, u64, &[u8])> {
    let (count, rest) = number(bytes, width)?;
    Some((0, each * count, rest))
}

/// A big-endian number of `width` bytes, at most 4.
fn number(bytes: &[u8], width: usize) -> Option<(u64, &[u8])> {
    let (digits, rest) = bytes.split_at_checked(width)?;
    let join = |number: u64, digit: &u8| number << 8 | u64::from(*digit);
    Some((digits.iter().fold(0, join), rest))
}
