//! How often values of which size occurred.

use std::fmt::Write as _;

/// Buckets of a factor of ten start at these times a power of ten.
const STARTS: [f64; 3] = [1.0, 2.0, 5.0];
/// Factors of ten that are drawn; smaller values are in the first bucket.
const MOST_DECADES: i32 = 8;
/// Parts of a character, for the ends of bars.
const EIGHTHS: [char; 8] = [' ', '▏', '▎', '▍', '▌', '▋', '▊', '▉'];
const LABEL: usize = 16;
const COUNT: usize = 8;
const LEAST_BAR: usize = 10;
/// Room for `p50 p99 max` behind a bar.
const NOTES: usize = 14;

/// A line with p50, p99 and the maximum, then a bar for each bucket; buckets are 1 to 2, 2
/// to 5 and 5 to 10 of each factor of ten. `values` are in `unit`, not negative; `width` is
/// in characters.
pub fn histogram(name: &str, unit: &str, values: &[f64], width: usize) -> String {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let (Some(first), Some(max)) = (sorted.first(), sorted.last()) else {
        return format!("{name}: no values\n");
    };
    let (p50, p99) = (rank(&sorted, 50), rank(&sorted, 99));
    let mut out = format!(
        "{name}: {} values, p50 {p50:.2} {unit}, p99 {p99:.2} {unit}, max {max:.2} {unit}\n",
        sorted.len()
    );
    // Zero has no logarithm: zeros are in the first bucket.
    let least = sorted.iter().copied().find(|value| *value > 0.0);
    let edges = edges(least.unwrap_or(1.0), *max);
    let bucket = |value: f64| edges.iter().skip(1).filter(|edge| value >= **edge).count();
    let count = |at: usize| sorted.iter().filter(|value| bucket(**value) == at).count();
    let counts: Vec<usize> = (0..edges.len()).map(count).collect();
    let most = counts.iter().copied().max().unwrap_or(1);
    let room = width
        .saturating_sub(LABEL + COUNT + NOTES + 6)
        .max(LEAST_BAR);
    for (at, count) in counts.iter().enumerate() {
        let from = if at == 0 && *first < edges[0] {
            0.0
        } else {
            edges[at]
        };
        let label = format!("{} to {}", short(from), short(next(edges[at])));
        let marks = [("p50", p50), ("p99", p99), ("max", *max)];
        let marks = marks.iter().filter(|(_, value)| bucket(*value) == at);
        let marks: Vec<&str> = marks.map(|(name, _)| *name).collect();
        let bar = format!("{} {}", bar(*count, most, room), marks.join(" "));
        let line = format!("  {label:>LABEL$}  {count:>COUNT$}  {bar}");
        let _ok = writeln!(out, "{}", line.trim_end());
    }
    out
}

/// The smallest value that `percent` of all do not exceed.
fn rank(sorted: &[f64], percent: usize) -> f64 {
    let rank = (sorted.len() * percent).div_ceil(100).max(1) - 1;
    sorted.get(rank).copied().unwrap_or(0.0)
}

/// Lower edges of the buckets from the one of `least` to the one of `max`.
fn edges(least: f64, max: f64) -> Vec<f64> {
    let last = if max > 0.0 { start(max) } else { 1.0 };
    let lowest = last * 10.0_f64.powi(-MOST_DECADES);
    let mut edges = vec![start(least.max(lowest))];
    // Edges carry rounding errors; neighbours differ by a factor of at least 2.
    while let Some(edge) = edges.last().copied().filter(|edge| *edge < last * 0.99) {
        edges.push(next(edge));
    }
    edges
}

/// Lower edge of the bucket of a positive value.
fn start(value: f64) -> f64 {
    let power = 10.0_f64.powf(value.log10().floor());
    // A value at an edge must not fall below it by rounding.
    let fits = |start: &&f64| **start * power <= value * (1.0 + 1.0e-9);
    STARTS.iter().rev().find(fits).unwrap_or(&1.0) * power
}

/// Lower edge of the bucket after the one at `edge`.
fn next(edge: f64) -> f64 {
    // The logarithm of a power of ten may be a little too small.
    let power = 10.0_f64.powf((edge * 1.01).log10().floor());
    let step = (edge / power).round();
    let after = STARTS.iter().find(|start| **start > step);
    after.unwrap_or(&10.0) * power
}

/// At least a thin line for one value: people look for the rare ones.
fn bar(count: usize, most: usize, room: usize) -> String {
    let eighths = (count * room * 8).div_ceil(most.max(1));
    let mut bar = "█".repeat(eighths / 8);
    if !eighths.is_multiple_of(8) {
        bar.push(EIGHTHS[eighths % 8]);
    }
    bar
}

fn short(value: f64) -> String {
    let digits = (-value.log10().floor()).clamp(0.0, 6.0) as usize;
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.digits$}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_value_is_in_the_bucket_it_belongs_to() {
        let values: Vec<f64> = [1.0, 1.9, 2.0, 4.9, 5.0, 9.9, 10.0, 700.0].to_vec();
        let text = histogram("lateness", "us", &values, 80);
        let rows: Vec<Vec<&str>> = text
            .lines()
            .skip(1)
            .map(|line| line.split_whitespace().collect())
            .collect();
        let counts: Vec<(&str, &str)> = rows.iter().map(|row| (row[0], row[3])).collect();
        let wanted = [
            ("1", "2"),
            ("2", "2"),
            ("5", "2"),
            ("10", "1"),
            ("20", "0"),
            ("50", "0"),
            ("100", "0"),
            ("200", "0"),
            ("500", "1"),
        ];
        assert_eq!(counts, wanted, "{text}");
        assert!(text.starts_with("lateness: 8 values, p50 4.90 us, p99 700.00 us, max 700.00 us"));
        assert!(text.lines().last().unwrap().ends_with("p99 max"), "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
    }

    #[test]
    fn one_value_among_thousands_is_seen() {
        let mut values = vec![3.0; 9999];
        values.push(4000.0);
        let text = histogram("a", "us", &values, 80);
        assert!(text.lines().last().unwrap().contains('▏'), "{text}");
    }

    #[test]
    fn none_zero_and_equal_values_do_no_harm() {
        assert_eq!(histogram("a", "us", &[], 80), "a: no values\n");
        assert!(histogram("a", "us", &[0.0, 0.0], 80).lines().count() == 2);
        let text = histogram("a", "us", &[0.0, 0.05, 7.0], 80);
        assert!(
            text.contains("0 to 0.1") && text.contains("5 to 10"),
            "{text}"
        );
        assert_eq!(histogram("a", "us", &[7.0; 5], 80).lines().count(), 2);
    }
}
