//! Charts of a difference that a verification found.

use std::fmt::Write as _;

use cell_sim::verify::{Around, Report};
use evaluation::charts::{Line, Panel};

/// Characters of a line, and rows of each of the two charts.
// Fits into a terminal of 100 characters.
const SIZE: (usize, usize) = (90, 8);

/// The first field that differs, half a second before and after: both values, and their
/// difference, which may be too small to be visible in the first chart. Empty where the
/// field is not a number.
pub(crate) fn charts(report: &Report) -> String {
    let (Some(first), [begin, .., end]) = (&report.first_difference, &report.around[..]) else {
        return String::new();
    };
    let seconds = |tick: u64| tick as f64 * 1.0e-3;
    let line = |name: &str, value: fn(&Around) -> f64| Line {
        name: name.to_owned(),
        points: report
            .around
            .iter()
            .map(|one| (seconds(one.tick), value(one)))
            .collect(),
    };
    let values = [
        line("recorded", |one| one.recorded),
        line("computed", |one| one.computed),
    ];
    let difference = [line("computed minus recorded", |one| {
        one.computed - one.recorded
    })];
    let span = (seconds(begin.tick), seconds(end.tick));
    let mut text = format!("\n\n{} around tick {}:\n", first.field, first.tick);
    // Two charts with a scale of their own: in one, a difference in the last bit would be the
    // same line twice.
    for lines in [values.to_vec(), difference.to_vec()] {
        let panel = Panel {
            unit: String::new(),
            lines,
        };
        let _ok = write!(text, "{}", evaluation::charts::chart(&panel, span, SIZE));
    }
    text.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use cell_sim::verify::Difference;

    use super::*;

    #[test]
    fn a_difference_too_small_for_the_values_is_drawn_alone() {
        let around = (0..100).map(|n| Around {
            tick: 10 * n,
            recorded: n as f64,
            computed: if n < 50 { n as f64 } else { n as f64 + 1.0e-9 },
        });
        let mut report = Report {
            first_difference: Some(Difference {
                message: "decision".to_owned(),
                generation: 1,
                seq: 51,
                tick: 500,
                field: "drops".to_owned(),
                recorded: "50.0".to_owned(),
                computed: "50.000000001".to_owned(),
            }),
            around: around.collect(),
            ..Report::default()
        };
        let text = charts(&report);
        for part in [
            "drops around tick 500:",
            "# the same",
            "computed minus recorded",
            "e-10",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
        report.around.clear();
        assert_eq!(charts(&report), "");
    }
}
