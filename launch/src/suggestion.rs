//! The known name nearest to one that is unknown.

/// `, did you mean ...?`, where a known name is near.
pub(crate) fn did_you_mean(asked: &str, known: &[String]) -> String {
    let distance = |name: &String| strsim::damerau_levenshtein(asked, name);
    match known.iter().min_by_key(|name| distance(name)) {
        Some(name) if distance(name) <= 2.max(asked.len() / 3) => {
            format!(", did you mean `{name}`?")
        }
        _ => String::new(),
    }
}
