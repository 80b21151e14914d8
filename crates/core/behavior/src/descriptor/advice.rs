//! "Did you mean" for names out of files, which may be very long and many.

use super::json::shortened;
use crate::suggest;

/// Longest name that is compared with known ones (bytes); longer ones are not typing errors.
// The comparison takes time proportional to the product of both lengths.
const LONGEST: usize = 100;
/// Number of known names that are compared.
// A hostile file has many unknown names: with this limit reading it still ends soon.
const COMPARED: usize = 256;
/// Names with so many equal first bytes are taken for the same name.
const BEGINNING: usize = 3;
/// Number of names in a list.
const LISTED: usize = 40;

/// `unknown WHAT 'NAME'; did you mean ...`.
pub(super) fn unknown(what: &str, name: &str, known: &[&str]) -> String {
    let advice = advice(name, known);
    format!("unknown {what} '{}'; {advice}", shortened(name))
}

/// The nearest known name, or the list of known names.
pub(crate) fn advice(name: &str, known: &[&str]) -> String {
    let compared = known.get(..COMPARED).unwrap_or(known);
    if name.len() <= LONGEST
        && let Some(near) = suggest::nearest(name, compared)
    {
        return format!("did you mean '{}'?", shortened(near));
    }
    // An abbreviation, or a name with a suffix, differs too much for the comparison by letters.
    let begins = |k: &&&str| k.len() >= BEGINNING && (k.starts_with(name) || name.starts_with(**k));
    if name.len() >= BEGINNING
        && let Some(near) = compared.iter().find(begins)
    {
        return format!("did you mean '{}'?", shortened(near));
    }
    let listed: Vec<String> = known.iter().take(LISTED).map(|k| shortened(k)).collect();
    match known.len() {
        0 => "none are known".to_owned(),
        count if count > LISTED => format!("known are: {}, ...", listed.join(", ")),
        _ => format!("known are: {}", listed.join(", ")),
    }
}
