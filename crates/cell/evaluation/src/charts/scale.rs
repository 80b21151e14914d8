//! Places of values on an axis, and the values that are marked on it.

/// More digits after the point than this are written as a power of ten.
const MOST_DIGITS: usize = 6;
/// Digits a number of this size has at most.
const ALL_DIGITS: usize = 15;

/// An axis from `low` to `high`.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    low: f64,
    high: f64,
    /// Between two marks: 1, 2 or 5 times a power of ten.
    step: f64,
}

impl Scale {
    /// An axis with about `marks` marks. A range of no length is widened.
    pub(crate) fn of((low, high): (f64, f64), marks: usize) -> Self {
        let room = match (low, high) {
            (low, high) if low < high => 0.0,
            (0.0, _) => 1.0,
            (low, _) => 0.1 * low.abs(),
        };
        let (low, high) = (low - room, high + room);
        let step = nice((high - low) / marks.max(1) as f64);
        Self { low, high, step }
    }

    /// Place of a value: 0 at the low end, 1 at the high end.
    pub(crate) fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Marked values, from low to high.
    pub(crate) fn marks(&self) -> Vec<f64> {
        // A mark at an end must not be lost by the rounding of a division.
        let first = (self.low / self.step - 1.0e-9).ceil();
        let last = (self.high / self.step + 1.0e-9).floor();
        let count = (last - first).clamp(-1.0, 100.0) + 1.0;
        // Adding 0 makes -0 positive, which would be written as `-0`.
        (0..count as usize)
            .map(|n| (first + n as f64) * self.step + 0.0)
            .collect()
    }

    /// A value as it is written at the axis.
    pub(crate) fn label(&self, value: f64) -> String {
        let digits = (-self.step.log10().floor()).max(0.0) as usize;
        let largest = self.low.abs().max(self.high.abs());
        let is_small = digits > MOST_DIGITS && largest < 1.0e-3;
        if is_small || largest >= 1.0e9 {
            return format!("{value:.1e}");
        }
        format!("{value:.*}", digits.min(ALL_DIGITS))
    }
}

/// 1, 2 or 5 times a power of ten that is about `length`.
fn nice(length: f64) -> f64 {
    let power = 10.0_f64.powf(length.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    let fits = |step: &&f64| **step * power >= 0.7 * length;
    steps.iter().find(fits).unwrap_or(&10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(range: (f64, f64), marks: usize) -> Vec<String> {
        let scale = Scale::of(range, marks);
        scale.marks().iter().map(|m| scale.label(*m)).collect()
    }

    #[test]
    fn marks_are_round_numbers_within_the_range() {
        assert_eq!(labels((-1.1, 2.3), 4), ["-1", "0", "1", "2"]);
        assert_eq!(labels((0.0, 0.9), 5), ["0.0", "0.2", "0.4", "0.6", "0.8"]);
        assert_eq!(labels((12.0, 59.5), 5), ["20", "30", "40", "50"]);
    }

    #[test]
    fn values_that_do_not_change_have_an_axis_around_them() {
        let scale = Scale::of((40.0, 40.0), 3);
        assert!((scale.share(40.0) - 0.5).abs() < 1e-9);
        assert!(scale.marks().contains(&40.0));
        assert_eq!(Scale::of((0.0, 0.0), 3).share(0.0), 0.5);
    }

    #[test]
    fn tiny_differences_can_be_read() {
        assert_eq!(
            labels((0.0, 3e-13), 3),
            ["0.0e0", "1.0e-13", "2.0e-13", "3.0e-13"]
        );
        let near = labels((1.000_000_01, 1.000_000_03), 2);
        assert_eq!(near, ["1.00000001", "1.00000002", "1.00000003"]);
    }
}
