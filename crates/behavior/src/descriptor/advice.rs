//! "Did you mean" for names out of files, which may be very long and many.

use super::json::shortened;
use crate::suggest;

/// Names longer than this are no typing errors.
const LONGEST: usize = 100;
/// Names that are compared.
const COMPARED: usize = 256;
/// Names that begin alike in so many bytes are meant for each other.
const BEGINNING: usize = 3;
/// Names that are listed.
const LISTED: usize = 40;

/// `there is no WHAT 'NAME'; did you mean ...`.
pub(super) fn unknown(what: &str, name: &str, known: &[&str]) -> String {
    let advice = advice(name, known);
    format!("there is no {what} '{}'; {advice}", shortened(name))
}

/// The nearest known name, or the list.
pub(crate) fn advice(name: &str, known: &[&str]) -> String {
    let compared = known.get(..COMPARED).unwrap_or(known);
    if name.len() <= LONGEST
        && let Some(near) = suggest::nearest(name, compared)
    {
        return format!("did you mean '{}'?", shortened(near));
    }
    let begins = |k: &&&str| k.len() >= BEGINNING && (k.starts_with(name) || name.starts_with(**k));
    if name.len() >= BEGINNING
        && let Some(near) = compared.iter().find(begins)
    {
        return format!("did you mean '{}'?", shortened(near));
    }
    let listed: Vec<String> = known.iter().take(LISTED).map(|k| shortened(k)).collect();
    match known.len() {
        0 => "there is none to choose from".to_owned(),
        count if count > LISTED => format!("known are: {}, ...", listed.join(", ")),
        _ => format!("known are: {}", listed.join(", ")),
    }
}
