//! TOML with errors that a person can act on: file, line, key, "did you mean".

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use crate::error::{Location, ModelError};
use crate::suggest;

/// Reads `text` as `T`. Refuses unknown keys (if `T` denies them) and every number that is not
/// finite.
pub(crate) fn parse<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, ModelError> {
    let table = table(file, text)?;
    // TOML has `inf` and `nan`: a number without a checked range would carry them on.
    refuse_non_finite(file, text, table.get_ref(), "")?;
    toml::from_str(text).map_err(|error| explain(file, text, &error))
}

/// The whole of `text`, with the position of every value.
pub(crate) fn table<'a>(
    file: &str,
    text: &'a str,
) -> Result<toml::Spanned<DeTable<'a>>, ModelError> {
    DeTable::parse(text).map_err(|error| explain(file, text, &error))
}

/// Reads the table `key` of `text` as `T`, except for the keys in `without`. Numbers are
/// finite, since [`parse`] has read the whole text before.
pub(crate) fn parse_table<T: DeserializeOwned>(
    file: &str,
    text: &str,
    key: &str,
    without: &[&str],
) -> Result<T, ModelError> {
    let parsed = table(file, text)?;
    let Some(mut value) = parsed.into_inner().remove(key) else {
        return Err(ModelError::value(
            Location::file(file),
            key,
            "missing",
            format!("a table [{key}] is needed"),
        ));
    };
    if let DeValue::Table(table) = value.get_mut() {
        for key in without {
            table.remove(*key);
        }
    }
    T::deserialize(ValueDeserializer::from(value)).map_err(|error| explain(file, text, &error))
}

/// A string at the top level, for listings.
pub(crate) fn top_level_string(text: &str, key: &str) -> Option<String> {
    let table = DeTable::parse(text).ok()?;
    let value = table.get_ref().get(key)?;
    value.get_ref().as_str().map(str::to_owned)
}

/// Line of the value at a dotted path such as `object.2.mass_kg`.
pub(crate) fn line_of(text: &str, path: &str) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let mut keys = path.split('.');
    let mut value = table.get_ref().get(keys.next()?)?;
    for key in keys {
        let next = match value.get_ref() {
            DeValue::Array(array) => key.parse().ok().and_then(|index: usize| array.get(index)),
            DeValue::Table(table) => table.get(key),
            _ => None,
        };
        match next {
            Some(next) => value = next,
            // Without the key the line of the table in which it would be is named.
            None => break,
        }
    }
    Some(line_at(text, value.span().start))
}

fn line_at(text: &str, offset: usize) -> usize {
    text.bytes()
        .take(offset)
        .filter(|byte| *byte == b'\n')
        .count()
        + 1
}

fn explain(file: &str, text: &str, error: &toml::de::Error) -> ModelError {
    let message = error.message();
    let line = error.span().map(|span| line_at(text, span.start));
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    match (message.starts_with("unknown field"), quoted.split_first()) {
        (true, Some((key, known))) => ModelError::UnknownKey {
            place: Location::line(file, line_of_key(text, key).or(line)),
            key: (*key).to_owned(),
            advice: suggest::advice(key, known),
        },
        _ => ModelError::Syntax {
            place: Location::line(file, line),
            message: message.trim().replace('\n', "; "),
        },
    }
}

/// The first line that assigns `key`. The parser loses the position of keys inside of tagged
/// tables.
fn line_of_key(text: &str, key: &str) -> Option<usize> {
    let assigns = |line: &str| {
        let mut rest = line;
        while let Some(at) = rest.find(key) {
            let (before, after) = (&rest[..at], &rest[at + key.len()..]);
            let starts =
                before.is_empty() || before.ends_with([' ', '\t', '{', ',', '.', '[', '"']);
            if starts
                && after
                    .trim_start_matches('"')
                    .trim_start()
                    .starts_with(['=', ']', '.'])
            {
                return true;
            }
            rest = after;
        }
        false
    };
    text.lines()
        .position(|line| assigns(line.split('#').next().unwrap_or("")))
        .map(|index| index + 1)
}

fn refuse_non_finite(
    file: &str,
    text: &str,
    table: &DeTable<'_>,
    path: &str,
) -> Result<(), ModelError> {
    for (key, value) in table {
        check_value(file, text, value, &join(path, key.get_ref()))?;
    }
    Ok(())
}

fn check_value(
    file: &str,
    text: &str,
    value: &toml::Spanned<DeValue<'_>>,
    path: &str,
) -> Result<(), ModelError> {
    match value.get_ref() {
        DeValue::Float(float) => {
            if float.as_str().parse::<f64>().is_ok_and(f64::is_finite) {
                return Ok(());
            }
            let place = Location::line(file, Some(line_at(text, value.span().start)));
            Err(ModelError::value(
                place,
                path,
                float.as_str(),
                "a finite number is needed",
            ))
        }
        DeValue::Array(array) => {
            let mut items = array.iter().enumerate();
            items.try_for_each(|(index, item)| {
                check_value(file, text, item, &join(path, &index.to_string()))
            })
        }
        DeValue::Table(table) => refuse_non_finite(file, text, table, path),
        _ => Ok(()),
    }
}

/// Appends a key to a dotted path.
pub(crate) fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Sample {
        #[serde(default)]
        #[allow(dead_code, reason = "only its key matters")]
        mass_kg: f64,
    }

    #[test]
    fn an_unknown_key_is_answered_with_line_and_suggestion() {
        let error = parse::<Sample>("a.toml", "\n\nmas_kg = 1.0")
            .unwrap_err()
            .to_string();
        assert_eq!(
            error,
            "a.toml:3: unknown key 'mas_kg'; did you mean 'mass_kg'?"
        );
    }

    #[test]
    fn nan_and_infinity_are_refused_wherever_they_stand() {
        for number in ["nan", "inf", "-inf"] {
            let text = format!("mass_kg = 1.0\nrest = [{{ a = [0.0, {number}] }}]");
            let error = parse::<Sample>("a.toml", &text).unwrap_err().to_string();
            assert!(error.starts_with("a.toml:2: rest.0.a.1 is"), "{error}");
        }
    }

    #[test]
    fn a_syntax_error_names_its_line() {
        let error = parse::<Sample>("a.toml", "\nmass_kg = = 1")
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("a.toml:2: "), "{error}");
    }
}
