//! "Did you mean": the nearest known name to a mistyped one.

/// Smallest similarity of two names that counts as a typing error (Damerau-
/// Levenshtein similarity, 0 to 1).
const SIMILAR: f64 = 0.6;

/// The known name nearest to `name`, if one is similar.
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let mut best = (SIMILAR, None);
    for candidate in known {
        let similarity =
            // In lower case, so that a wrong capital letter costs no similarity.
            strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase());
        if similarity > best.0 {
            best = (similarity, Some(*candidate));
        }
    }
    best.1
}

/// Advice for an unknown `name`: the nearest known one, or the list of all.
///
/// ```
/// let advice = behavior::suggest::advice("fms", &["fsm", "ifelse"]);
/// assert_eq!(advice, "did you mean 'fsm'?");
/// ```
pub fn advice(name: &str, known: &[&str]) -> String {
    if let Some(near) = nearest(name, known) {
        return format!("did you mean '{near}'?");
    }
    match known {
        [] => "none are known".to_owned(),
        _ => format!("known are: {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typing_error_gets_one_name_and_nonsense_gets_the_list() {
        assert_eq!(
            advice("frnka-stack", &["franka-stack", "reach"]),
            "did you mean 'franka-stack'?"
        );
        assert_eq!(
            advice("xyz", &["franka-stack", "reach"]),
            "known are: franka-stack, reach"
        );
    }
}
