//! Names of policies.

use cell_model::runs::policy_name;

use crate::failure::Failure;

/// `asked`, if the demo has it, else its default.
pub fn choose(
    asked: Option<&str>,
    known: &[String],
    default: &str,
    demo: &str,
) -> Result<String, Failure> {
    let Some(asked) = asked else {
        return Ok(default.to_owned());
    };
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    if let Some(policy) = policy_name::policy_named(asked, &known) {
        return Ok(policy.to_owned());
    }
    let refusal = policy_name::unknown_policy(asked, &known, demo);
    Err(Failure::configuration(refusal))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_policy_is_answered_with_the_near_and_the_known_ones() {
        let known = ["fsm".to_owned(), "ifelse".to_owned()];
        assert_eq!(choose(None, &known, "fsm", "d").unwrap(), "fsm");
        assert_eq!(
            choose(Some("ifelse"), &known, "fsm", "d").unwrap(),
            "ifelse"
        );
        let message = choose(Some("ifels"), &known, "fsm", "d")
            .unwrap_err()
            .to_string();
        assert!(message.contains("did you mean 'ifelse'?"), "{message}");
        let message = choose(Some("quantum"), &known, "fsm", "d")
            .unwrap_err()
            .to_string();
        assert!(message.contains("known are: fsm, ifelse"), "{message}");
    }
}
