//! Structs without words that are zero: joints that an arm does not have, the second arm of a
//! cell with one, the rest of a text. One pass over the words reduces most structs to a third.
//!
//! Packing runs for every message at 1 kHz beside the loops, with a budget of 1 % of one core
//! for the whole recorder (ADR 0015); hence no general compression here, no branch per word,
//! and no allocation.

/// Bytes of a word.
const WORD: usize = 8;
/// Words covered by one mask.
const GROUP: usize = 64;
/// Words examined together; a divisor of those of a group.
// 64 bytes, a cache line: long runs of zeros cost one comparison per line.
const RUN: usize = 8;
/// Bytes of the length at the front.
const FRONT: usize = 4;
/// Longest struct (bytes); a longer one does not compile, see `entry.rs`.
// A damaged length must not reserve memory; the largest message, a checkpoint, has 16 KiB.
pub(crate) const MAX_BYTES: usize = 1 << 20;

/// Appends `bytes`, packed, to `out`: their number (u32); a mask (u64) for every
/// 64 words of eight bytes, bit `i` set where word `i` is not zero; those words.
/// All little-endian; a last word that is cut is filled up with zeros.
pub fn pack(bytes: &[u8], out: &mut Vec<u8>) {
    // Longer structs are not ours and could not be unpacked.
    let bytes = bytes.get(..MAX_BYTES).unwrap_or(bytes);
    out.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
    // Room for the masks first: they are known only after their words are written.
    let masks_at = out.len();
    out.resize(masks_at + masks(bytes.len()) * WORD, 0);
    for (group, block) in bytes.chunks(WORD * GROUP).enumerate() {
        let mask = pack_group(block, out);
        let at = masks_at + group * WORD;
        if let Some(place) = out.get_mut(at..at + WORD) {
            place.copy_from_slice(&mask.to_le_bytes());
        }
    }
}

/// Appends the words of a group that are not zero to `out`; returns their mask.
fn pack_group(block: &[u8], out: &mut Vec<u8>) -> u64 {
    let (mut kept, mut count, mut mask) = ([0_u64; GROUP], 0, 0);
    let mut keep = |index: usize, value: u64| {
        // Without a branch: single zero words have no pattern that a processor could predict.
        if let Some(place) = kept.get_mut(count) {
            *place = value;
        }
        let is_kept = value != 0;
        count += usize::from(is_kept);
        mask |= u64::from(is_kept) << index;
    };
    let (words, cut) = block.as_chunks::<WORD>();
    for (run, words) in words.chunks(RUN).enumerate() {
        let any = words.iter().fold(0, |any, w| any | u64::from_le_bytes(*w));
        // Long runs of zeros have one.
        if any == 0 {
            continue;
        }
        for (index, word) in (run * RUN..).zip(words) {
            keep(index, u64::from_le_bytes(*word));
        }
    }
    if !cut.is_empty() {
        keep(words.len(), value(cut));
    }
    let at = out.len();
    out.resize(at + count * WORD, 0);
    let places = out.get_mut(at..).unwrap_or_default();
    for (place, value) in places.as_chunks_mut::<WORD>().0.iter_mut().zip(&kept) {
        *place = value.to_le_bytes();
    }
    mask
}

/// The input of [`pack`]; `None` for anything it cannot have produced.
pub fn unpack(packed: &[u8]) -> Option<Vec<u8>> {
    let (front, rest) = packed.split_at_checked(FRONT)?;
    let length = u32::from_le_bytes(front.try_into().ok()?) as usize;
    if length > MAX_BYTES {
        return None;
    }
    let (masks, words) = rest.split_at_checked(masks(length) * WORD)?;
    let mut words = words.chunks(WORD);
    let mut bytes = vec![0; length.next_multiple_of(WORD)];
    let groups = bytes.chunks_mut(WORD * GROUP).zip(masks.chunks(WORD));
    for (block, mask) in groups {
        let mut mask = value(mask);
        // One step for each word that is kept, not for each of 64.
        while mask != 0 {
            let at = mask.trailing_zeros() as usize * WORD;
            let word = words.next().filter(|word| word.len() == WORD)?;
            block.get_mut(at..at + WORD)?.copy_from_slice(word);
            mask &= mask - 1;
        }
    }
    bytes.truncate(length);
    // Words that no mask names are damage as well.
    words.next().is_none().then_some(bytes)
}

/// Masks of a struct of `bytes`.
fn masks(bytes: usize) -> usize {
    bytes.div_ceil(WORD * GROUP)
}

fn value(word: &[u8]) -> u64 {
    if let Ok(whole) = word.try_into() {
        return u64::from_le_bytes(whole);
    }
    let byte = |value, byte: &u8| value << 8 | u64::from(*byte);
    word.iter().rev().fold(0, byte)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut out = vec![9];
        pack(bytes, &mut out);
        assert_eq!(out.remove(0), 9, "what was there stays");
        out
    }

    #[test]
    fn every_length_comes_back_whole() {
        for length in (0..40).chain([511, 512, 513, 2377, 20_000]) {
            let byte = |i: usize| if i % 31 < 20 { 0 } else { i as u8 };
            let bytes: Vec<u8> = (0..length).map(byte).collect();
            assert_eq!(unpack(&packed(&bytes)), Some(bytes));
        }
    }

    #[test]
    fn zeros_cost_a_mask_and_a_word_is_where_the_mask_says() {
        let mut bytes = [0; 1024];
        assert_eq!(packed(&bytes).len(), FRONT + 2 * WORD);
        bytes[8 * 65] = 7;
        let packed = packed(&bytes);
        assert_eq!(packed[..4], 1024_u32.to_le_bytes());
        assert_eq!(
            packed[4..20],
            [0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0]
        );
        assert_eq!(packed[20..], [7, 0, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn nothing_else_is_taken_for_it() {
        let whole = packed(&[1; 100]);
        for length in 0..whole.len() {
            assert_eq!(unpack(&whole[..length]), None, "{length}");
        }
        let longer = [&whole[..], &[0]].concat();
        let mut beyond = whole.clone();
        // A word behind the last one.
        beyond[5] |= 0x80;
        let huge = [0xff; 64];
        for wrong in [&longer[..], &beyond, &huge] {
            assert_eq!(unpack(wrong), None);
        }
    }
}
