//! Charts of numbers over time, as characters or as SVG, and histograms of durations.
//! Pure: numbers in, text out; no terminal, no file.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers of characters and pixels, clamped before they are cast"
)]

mod histogram;
mod scale;
mod svg;
mod text;

pub use histogram::histogram;
pub use svg::svg;
pub use text::chart;

/// Lines that can be told apart in a panel: an SVG has eight colours, solid and dashed.
pub const MAX_LINES: usize = 16;

/// Values over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Name of the quantity.
    pub name: String,
    /// Time (s) and value; the line is interrupted where a value is not finite.
    pub points: Vec<(f64, f64)>,
}

/// Lines of one unit with common axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Unit of the values; empty for plain numbers.
    pub unit: String,
    /// The lines, at most [`MAX_LINES`]; more are not drawn.
    pub lines: Vec<Line>,
}

impl Panel {
    /// The points of a line within `span` (s), with gaps.
    fn within(line: &Line, span: (f64, f64)) -> impl Iterator<Item = (f64, f64)> {
        let points = line.points.iter().copied();
        points.filter(move |(at, _)| (span.0..=span.1).contains(at))
    }

    /// Smallest and largest value within `span`; `None` where there is no value.
    fn range(&self, span: (f64, f64)) -> Option<(f64, f64)> {
        let lines = self.lines.iter().take(MAX_LINES);
        let values = lines.flat_map(|line| Self::within(line, span));
        let values = values.map(|(_, value)| value).filter(|v| v.is_finite());
        values.fold(None, |range, value| {
            let (low, high) = range.unwrap_or((value, value));
            Some((value.min(low), value.max(high)))
        })
    }
}
