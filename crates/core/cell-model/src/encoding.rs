//! Bytes of a file as text. Files are UTF-8; the error names another encoding, so that an
//! editor can convert it.

/// Number of bytes that are searched for UTF-16 without a mark.
const LOOKED_AT: usize = 4096;

/// `bytes` as text.
///
/// # Errors
/// Returns the encoding that the bytes seem to have, and advice.
pub(crate) fn text(bytes: Vec<u8>) -> Result<String, String> {
    // Before UTF-8: text in UTF-16 of plain letters is valid UTF-8 with zeros, and would be
    // accepted.
    if let Some(name) = utf_16(&bytes) {
        return Err(format!("it is {name} text; save it as UTF-8"));
    }
    let wrong = match String::from_utf8(bytes) {
        Ok(text) => return Ok(text),
        Err(error) => error,
    };
    let at = wrong.utf8_error().valid_up_to();
    let bytes = wrong.as_bytes();
    let byte = bytes.get(at).copied().unwrap_or_default();
    let before = bytes.get(..at).unwrap_or_default();
    let line = before.split(|byte| *byte == b'\n').count();
    let is_text = |byte: &u8| *byte >= b' ' || b"\t\r\n\x0c".contains(byte);
    if bytes.iter().all(is_text) {
        return Err(format!(
            "it is Latin-1 or Windows-1252 text, as '{}' (byte 0x{byte:02x}) in line {line} shows; \
             save it as UTF-8",
            char::from(byte)
        ));
    }
    Err(format!(
        "it is not text: byte 0x{byte:02x} in line {line} is not UTF-8"
    ))
}

/// The kind of UTF-16: from its mark, or because every other byte of plain letters is zero.
fn utf_16(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(&[0xff, 0xfe]) {
        return Some("UTF-16 (little endian)");
    }
    if bytes.starts_with(&[0xfe, 0xff]) {
        return Some("UTF-16 (big endian)");
    }
    let start = bytes.get(..LOOKED_AT).unwrap_or(bytes);
    let (mut even, mut odd, mut pairs) = (0, 0, 0);
    for pair in start.chunks_exact(2) {
        pairs += 1;
        even += usize::from(pair.first() == Some(&0));
        odd += usize::from(pair.last() == Some(&0));
    }
    match (even, odd) {
        (0, odd) if odd > 0 && odd * 2 >= pairs => Some("UTF-16 (little endian, without a mark)"),
        (even, 0) if even > 0 && even * 2 >= pairs => Some("UTF-16 (big endian, without a mark)"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_encodings_are_called_by_their_name() {
        let little =
            |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
        let big =
            |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_be_bytes).collect() };
        let said = |bytes: Vec<u8>| text(bytes).unwrap_err();
        assert!(said(little("\u{feff}a = 1\n")).contains("UTF-16 (little endian)"));
        assert!(said(big("\u{feff}a = 1\n")).contains("UTF-16 (big endian)"));
        assert!(said(little("a = 'ü'\n")).contains("little endian, without a mark"));
        assert!(said(big("{\"a\": 1}")).contains("big endian, without a mark"));
        let latin = said(b"a = 1\n# gr\xfcn\n".to_vec());
        assert!(
            latin.contains("Latin-1") && latin.contains("'ü' (byte 0xfc) in line 2"),
            "{latin}"
        );
        assert!(said(b"\x7fELF\x02\x01\x01\x00\xff\xfe".to_vec()).contains("not text"));
        for good in ["", "a", "a = 'ü'\n", "\u{feff}{}", "\0"] {
            assert_eq!(text(good.as_bytes().to_vec()).as_deref(), Ok(good));
        }
    }
}
