//! A scan of a URDF before it is parsed. The parser builds a recursive tree and overflows the
//! stack on deep nesting; this scan keeps only a counter.

use crate::error::{Location, ModelError};

/// Largest nesting of elements: a URDF needs about 5.
pub(crate) const MAX_DEPTH: usize = 64;
/// Largest URDF that is read (bytes).
pub(crate) const MAX_BYTES: usize = 4 << 20;

/// Checks size and nesting of a URDF.
///
/// # Errors
/// Returns [`ModelError::Value`] with the line at which the nesting is too deep.
pub(crate) fn scan(file: &str, text: &str) -> Result<(), ModelError> {
    if text.len() > MAX_BYTES {
        let allowed =
            format!("at most {MAX_BYTES} bytes; remove content that does not describe the robot");
        return Err(ModelError::value(
            Location::file(file),
            "size",
            text.len(),
            allowed,
        ));
    }
    let mut depth = 0_usize;
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        rest = &rest[start..];
        // Entities of a document type can expand to gigabytes.
        if rest.starts_with("<!DOCTYPE") || rest.starts_with("<!ENTITY") {
            let place = Location::line(file, Some(line_of(text, rest)));
            return Err(ModelError::value(
                place,
                "document type",
                "given",
                "a URDF has none; remove it",
            ));
        }
        let (tag, after) = next_tag(rest);
        rest = after;
        match kind(tag) {
            Kind::Open => depth += 1,
            Kind::Close => depth = depth.saturating_sub(1),
            Kind::Other => {}
        }
        if depth > MAX_DEPTH {
            let place = Location::line(file, Some(line_of(text, rest)));
            let allowed =
                format!("at most {MAX_DEPTH} elements inside each other; a URDF needs about 5");
            return Err(ModelError::value(place, "nesting", depth, allowed));
        }
    }
    Ok(())
}

enum Kind {
    Open,
    Close,
    Other,
}

fn kind(tag: &str) -> Kind {
    if tag.starts_with("<!") || tag.starts_with("<?") || tag.ends_with("/>") {
        Kind::Other
    } else if tag.starts_with("</") {
        Kind::Close
    } else {
        Kind::Open
    }
}

/// Splits off the markup at the start of `text`; the rest is empty if the markup has no end.
fn next_tag(text: &str) -> (&str, &str) {
    for (open, close) in [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")] {
        if text.starts_with(open) {
            return match text.find(close) {
                Some(at) => text.split_at(at + close.len()),
                None => (text, ""),
            };
        }
    }
    let mut quote = None;
    // A `>` within quotes does not end a tag.
    for (at, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            (None, b'>') => return text.split_at(at + 1),
            _ => {}
        }
    }
    (text, "")
}

fn line_of(text: &str, rest: &str) -> usize {
    let offset = text.len() - rest.len();
    text.bytes()
        .take(offset)
        .filter(|byte| *byte == b'\n')
        .count()
        + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_thousand_nested_elements_are_one_error() {
        let text = format!(
            "<robot>\n{}{}</robot>",
            "<a>".repeat(20_000),
            "</a>".repeat(20_000)
        );
        let error = scan("deep.urdf", &text).unwrap_err().to_string();
        assert!(error.starts_with("deep.urdf:2: nesting is 65"), "{error}");
    }

    #[test]
    fn comments_declarations_and_quoted_brackets_do_not_count() {
        let inner = "<!-- <a><a> --><b name='<<<>'/>".repeat(100);
        scan(
            "a.urdf",
            &format!("<?xml version='1.0'?><robot>{inner}</robot>"),
        )
        .unwrap();
    }

    #[test]
    fn entities_and_unfinished_markup_are_no_trouble() {
        assert!(scan("a.urdf", "<!DOCTYPE x [<!ENTITY a 'b'>]><robot/>").is_err());
        scan("a.urdf", "<robot <<< '").unwrap();
        scan("a.urdf", "<!-- forever").unwrap();
    }
}
