//! The result of a search, as it is printed.

use super::*;

fn tried(value: f64, done: u64) -> Tried {
    Tried {
        value: Number::from_f64(value).unwrap(),
        done,
        episodes: 10,
        holds: done >= 9,
        first_failed: None,
    }
}

/// The result after these values were tried, each with the number of its episodes that were done.
fn found(values: &[(f64, u64)]) -> Found {
    let mut found = Found {
        key: "disturbance.position_offset_m".to_owned(),
        seeds: [1, 10],
        least_done: 0.9,
        holds: None,
        breaks: None,
        tried: Vec::new(),
    };
    for (value, done) in values {
        found.take(tried(*value, *done));
    }
    found
}

#[test]
fn the_limit_of_a_task_is_between_the_nearest_values_that_were_tried() {
    let key = "disturbance.position_offset_m";
    let cases: [(&[(f64, u64)], String); 4] = [
        (
            &[(0.0, 10), (0.04, 0), (0.02, 9), (0.03, 8)],
            format!("{key} breaks the task between 0.02 and 0.03"),
        ),
        (
            &[(0.01, 3)],
            format!("{key} breaks the task at 0.01, the lower bound, already"),
        ),
        (
            &[(0.0, 10), (0.04, 10)],
            format!("the task holds up to {key}=0.04, the upper bound"),
        ),
        (&[], format!("no value of {key} was tried")),
    ];
    for (values, verdict) in cases {
        let found = found(values);
        assert_eq!(found.verdict(), verdict);
        assert_eq!(
            found.tried.len(),
            values.len(),
            "in the order they were tried"
        );
    }
}
