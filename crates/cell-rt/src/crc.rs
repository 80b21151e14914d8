//! CRC-32 (polynomial 0xEDB88320 reflected, as in IEEE 802.3).

const TABLE: [u32; 256] = table();

#[allow(clippy::cast_possible_truncation, reason = "the index is below 256")]
const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        let mut value = i as u32;
        let mut bit = 0;
        while bit < 8 {
            value = if value & 1 == 1 {
                (value >> 1) ^ 0xEDB8_8320
            } else {
                value >> 1
            };
            bit += 1;
        }
        table[i] = value;
        i += 1;
    }
    table
}

/// Continues the checksum `crc` (0 at the start) over `bytes`.
pub(crate) fn crc32(crc: u32, bytes: &[u8]) -> u32 {
    let mut value = !crc;
    for byte in bytes {
        value = (value >> 8) ^ TABLE[((value ^ u32::from(*byte)) & 0xff) as usize];
    }
    !value
}

#[cfg(test)]
mod tests {
    use super::crc32;

    #[test]
    fn the_check_value_of_the_standard_comes_out() {
        assert_eq!(crc32(0, b"123456789"), 0xCBF4_3926);
        assert_eq!(crc32(crc32(0, b"1234"), b"56789"), 0xCBF4_3926);
    }
}
