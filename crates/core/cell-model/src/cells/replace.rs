//! Leaves of the task's tree that answer without being run, for `--replace`.

use std::path::Path;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::data::read_text;
use crate::error::{Location, ModelError};

/// The answer of a replaced leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReplacedAnswer {
    /// It has succeeded.
    Success,
    /// It has failed.
    Failure,
    /// It is not finished.
    Running,
}

/// One leaf, and its answer for a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Replace {
    /// Id of the leaf.
    pub node: String,
    /// Its answer.
    pub result: ReplacedAnswer,
    /// From this time of the task on (s).
    #[serde(default)]
    pub from_s: f64,
    /// For so long (s); to the end where missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

impl Replace {
    fn checked(self) -> Result<Self, String> {
        if self.node.is_empty() {
            return Err("'node' is empty; it is the id of a leaf".to_owned());
        }
        for (key, seconds) in [("from_s", Some(self.from_s)), ("for_s", self.for_s)] {
            let fits = |seconds: f64| seconds.is_finite() && seconds >= 0.0;
            if let Some(seconds) = seconds.filter(|seconds| !fits(*seconds)) {
                return Err(format!(
                    "'{key}' is {seconds}; seconds of 0 or more are needed"
                ));
            }
        }
        Ok(self)
    }
}

impl FromStr for Replace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "'{text}' replaces no leaf; write NODE=success, NODE=failure or \
                 NODE=running, each with :SECONDS for a time, or the name of a FILE.jsonl"
            )
        };
        // From the right: an id may contain `=`, a result may not.
        let (node, result) = text.rsplit_once('=').ok_or_else(wrong)?;
        let (result, for_s) = match result.split_once(':') {
            Some((result, seconds)) => (result, Some(seconds.parse().map_err(|_| wrong())?)),
            None => (result, None),
        };
        let result = match result {
            "success" => ReplacedAnswer::Success,
            "failure" => ReplacedAnswer::Failure,
            "running" => ReplacedAnswer::Running,
            _ => return Err(wrong()),
        };
        let rule = Self {
            node: node.to_owned(),
            result,
            from_s: 0.0,
            for_s,
        };
        rule.checked()
    }
}

/// The rules of arguments: `NODE=RESULT[:SECONDS]`, or a file with one rule a line.
///
/// # Errors
/// Returns [`ModelError`] for a file that cannot be read, and for a line that is not a rule.
pub fn of_arguments(arguments: &[String]) -> Result<Vec<Replace>, ModelError> {
    let mut rules = Vec::new();
    for argument in arguments {
        // By its name, not by whether it exists: a misspelt file is then reported as missing.
        if Path::new(argument)
            .extension()
            .is_some_and(|e| e == "jsonl")
        {
            rules.extend(of_text(argument, &read_text(Path::new(argument))?)?);
        } else {
            let rule = argument.parse();
            rules.push(rule.map_err(|why| refused("--replace", None, argument, why))?);
        }
    }
    Ok(rules)
}

/// The rules of a file, one JSON object a line.
///
/// # Errors
/// Returns [`ModelError`] with the line that is not a rule.
pub fn of_text(file: &str, text: &str) -> Result<Vec<Replace>, ModelError> {
    let lines = (1..).zip(text.lines());
    let lines = lines.filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(number, line)| {
            let rule: Result<Replace, String> =
                serde_json::from_str(line).map_err(|error| error.to_string());
            rule.and_then(Replace::checked)
                .map_err(|why| refused(file, Some(number), line, why))
        })
        .collect()
}

fn refused(file: &str, line: Option<usize>, text: &str, why: String) -> ModelError {
    // Shortened: a line of a wrong file may be megabytes.
    let mut shown: String = text.chars().take(60).collect();
    if shown.len() < text.len() {
        shown.push('…');
    }
    ModelError::value(Location::line(file, line), "replace", shown, why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_read_as_people_write_them() {
        let rule: Replace = "tower/bring[red_1]=running:2.5".parse().unwrap();
        assert_eq!(rule.node, "tower/bring[red_1]");
        assert_eq!(
            (rule.result, rule.for_s),
            (ReplacedAnswer::Running, Some(2.5))
        );
        for wrong in [
            "a",
            "a=ok",
            "=success",
            "a=success:x",
            "a=success:-1",
            "a=success:nan",
        ] {
            assert!(wrong.parse::<Replace>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_file_has_a_rule_a_line() {
        let text = "{\"node\": \"a\", \"result\": \"failure\", \"from_s\": 1, \"for_s\": 2}\n\n";
        let rules = of_text("r.jsonl", text).unwrap();
        assert_eq!((rules[0].from_s, rules[0].for_s), (1.0, Some(2.0)));
        let wrong = of_text("r.jsonl", "\n{\"node\": \"a\"}")
            .unwrap_err()
            .to_string();
        assert!(
            wrong.contains("r.jsonl:2") && wrong.contains("result"),
            "{wrong}"
        );
    }
}
