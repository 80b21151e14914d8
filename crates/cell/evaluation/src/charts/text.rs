//! A panel as characters.

use std::fmt::Write as _;

use super::scale::Scale;
use super::{Line, MAX_LINES, Panel};

/// Characters for the lines of a panel with several.
const GLYPHS: [char; MAX_LINES] = [
    'o', 'x', '+', '*', 'a', 'b', 'c', 'd', 'e', 'f', 'g', 'h', 'i', 'j', 'k', 'l',
];
/// Where several of them meet.
const MEET: char = '#';
/// Rows of the chart for each mark of its values.
const ROWS_A_MARK: usize = 2;
/// Columns of the chart for each mark of time.
const COLUMNS_A_MARK: usize = 14;
const LEAST_COLUMNS: usize = 10;
/// Dots of a braille character, across and down.
const DOTS: (usize, usize) = (2, 4);

/// `panel` between the times of `span` (s), `columns` characters wide and with `rows` rows
/// between the axes. One line is drawn in dots of braille; several have a character each.
pub fn chart(panel: &Panel, span: (f64, f64), (columns, rows): (usize, usize)) -> String {
    let mut out = title(panel);
    let Some(range) = panel.range(span) else {
        out.push_str("  no values\n");
        return out;
    };
    let rows = rows.max(2);
    let values = Scale::of(range, rows.div_ceil(ROWS_A_MARK));
    let marks: Vec<(usize, String)> = values
        .marks()
        .into_iter()
        .map(|mark| (row(values.share(mark), rows), values.label(mark)))
        .collect();
    let label_width = marks.iter().map(|(_, label)| label.len()).max();
    let label_width = label_width.unwrap_or(0);
    let columns = columns.saturating_sub(label_width + 2).max(LEAST_COLUMNS);
    let times = Scale::of(span, columns.div_ceil(COLUMNS_A_MARK));
    let drawn = if panel.lines.len() > 1 {
        characters(panel, span, (&times, &values), (columns, rows))
    } else {
        braille(panel, span, (&times, &values), (columns, rows))
    };
    for (at, line) in drawn.iter().enumerate() {
        let mark = marks.iter().find(|(row, _)| *row == at);
        let (label, axis) = mark.map_or(("", '│'), |(_, label)| (label.as_str(), '┤'));
        let _ok = writeln!(out, "{label:>label_width$} {axis}{}", line.trim_end());
    }
    time_axis(&mut out, &times, label_width, columns);
    out
}

/// Name and unit, or each line with its character.
fn title(panel: &Panel) -> String {
    let unit = match panel.unit.as_str() {
        "" => String::new(),
        unit => format!(" ({unit})"),
    };
    let names: Vec<String> = match &panel.lines[..] {
        [line] => vec![line.name.clone()],
        lines => lines
            .iter()
            .zip(GLYPHS)
            .map(|(line, glyph)| format!("{glyph} {}", line.name))
            .chain(std::iter::once(format!("{MEET} the same")))
            .collect(),
    };
    format!("{}{unit}\n", names.join("  "))
}

/// Row of a share of the value axis; the first row is the highest.
fn row(share: f64, rows: usize) -> usize {
    place(1.0 - share, rows)
}

fn place(share: f64, count: usize) -> usize {
    let last = count.saturating_sub(1) as f64;
    (share * last).round().clamp(0.0, last) as usize
}

/// The lines that pass through each place, a bit for each.
struct Grid {
    columns: usize,
    rows: usize,
    // 16 bits, as `MAX_LINES` is 16.
    passed: Vec<u16>,
}

impl Grid {
    fn new((columns, rows): (usize, usize)) -> Self {
        Self {
            columns,
            rows,
            passed: vec![0; columns * rows],
        }
    }

    fn at(&self, column: usize, row: usize) -> u16 {
        let place = row * self.columns + column;
        self.passed.get(place).copied().unwrap_or(0)
    }

    /// Draws the way from one point to the next; a point alone is a dot.
    fn draw(&mut self, line: &Line, bit: u16, span: (f64, f64), axes: (&Scale, &Scale)) {
        let mut before = None;
        for (at, value) in Panel::within(line, span) {
            if !value.is_finite() {
                before = None;
                continue;
            }
            let to = (
                place(axes.0.share(at), self.columns),
                row(axes.1.share(value), self.rows),
            );
            // Many samples of a recording fall on one place, which is drawn once.
            if before != Some(to) {
                self.segment(before.unwrap_or(to), to, bit);
            }
            before = Some(to);
        }
    }

    fn segment(&mut self, from: (usize, usize), to: (usize, usize), bit: u16) {
        let steps = from.0.abs_diff(to.0).max(from.1.abs_diff(to.1)).max(1);
        for step in 0..=steps {
            let part = step as f64 / steps as f64;
            let between = |a: usize, b: usize| (a as f64 + (b as f64 - a as f64) * part).round();
            let (column, row) = (between(from.0, to.0), between(from.1, to.1));
            let place = row as usize * self.columns + column as usize;
            if let Some(place) = self.passed.get_mut(place) {
                *place |= bit;
            }
        }
    }
}

/// The only line of the panel, finer than characters are.
fn braille(
    panel: &Panel,
    span: (f64, f64),
    axes: (&Scale, &Scale),
    (columns, rows): (usize, usize),
) -> Vec<String> {
    let mut grid = Grid::new((columns * DOTS.0, rows * DOTS.1));
    for line in panel.lines.iter().take(1) {
        grid.draw(line, 1, span, axes);
    }
    // Bits of the dots, by row and column. Unicode numbers the upper three rows by column, and
    // the lowest row, a later addition, after them.
    let bits = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
    let character = |column: usize, row: usize| {
        let mut code = 0x2800_u32;
        for (down, across) in bits.iter().enumerate() {
            for (right, bit) in across.iter().enumerate() {
                if grid.at(column * DOTS.0 + right, row * DOTS.1 + down) != 0 {
                    code |= bit;
                }
            }
        }
        // The empty pattern is no white space: `trim_end` would keep it at the end of a line.
        if code == 0x2800 {
            ' '
        } else {
            char::from_u32(code).unwrap_or(' ')
        }
    };
    (0..rows)
        .map(|row| (0..columns).map(|column| character(column, row)).collect())
        .collect()
}

/// Several lines, a character each.
fn characters(
    panel: &Panel,
    span: (f64, f64),
    axes: (&Scale, &Scale),
    size: (usize, usize),
) -> Vec<String> {
    let mut grid = Grid::new(size);
    for (index, line) in panel.lines.iter().take(MAX_LINES).enumerate() {
        grid.draw(line, 1 << index, span, axes);
    }
    let character = |passed: u16| match passed.count_ones() {
        0 => ' ',
        1 => GLYPHS[passed.trailing_zeros() as usize % MAX_LINES],
        _ => MEET,
    };
    (0..size.1)
        .map(|row| {
            (0..size.0)
                .map(|column| character(grid.at(column, row)))
                .collect()
        })
        .collect()
}

fn time_axis(out: &mut String, times: &Scale, label_width: usize, columns: usize) {
    let mut axis = vec!['─'; columns];
    let mut labels = String::new();
    for mark in times.marks() {
        let at = place(times.share(mark), columns);
        axis[at] = '┬';
        let label = format!("{} s", times.label(mark));
        // Its middle below the mark, as far as there is room.
        let last = columns.saturating_sub(label.len());
        let from = at.saturating_sub(label.len() / 2).min(last);
        let written = labels.chars().count();
        if from >= written + usize::from(written > 0) {
            let gap = from - written;
            let _ok = write!(labels, "{:gap$}{label}", "");
        }
    }
    let axis: String = axis.into_iter().collect();
    let _ok = writeln!(out, "{:label_width$} └{axis}", "");
    let _ok = writeln!(out, "{:label_width$}  {labels}", "");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(name: &str, value: impl Fn(f64) -> f64) -> Line {
        let points = (0..=1000).map(|ms| f64::from(ms) / 1000.0);
        Line {
            name: name.to_owned(),
            points: points.map(|at| (at, value(at))).collect(),
        }
    }

    #[test]
    fn a_line_rises_from_the_lower_left_to_the_upper_right() {
        let panel = Panel {
            unit: "°".to_owned(),
            lines: vec![line("arm/joint1 position", |at| 90.0 * at)],
        };
        let text = chart(&panel, (0.0, 1.0), (50, 7));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "arm/joint1 position (°)");
        assert_eq!(lines.len(), 1 + 7 + 2, "{text}");
        assert!(
            lines.iter().all(|line| line.chars().count() <= 50),
            "{text}"
        );
        assert!(
            lines[1].ends_with(|c| ('\u{2801}'..='\u{28ff}').contains(&c)),
            "{text}"
        );
        assert!(
            lines[7].starts_with(" 0 ┤") && lines[7].chars().count() < 20,
            "{text}"
        );
        assert!(lines[8].contains("└┬"), "{text}");
        assert!(
            lines[9].contains("0.0 s") && lines[9].contains("1.0 s"),
            "{text}"
        );
    }

    #[test]
    fn a_gap_interrupts_the_line() {
        let gap = |at: f64| {
            if (0.4..0.6).contains(&at) {
                f64::NAN
            } else {
                1.0
            }
        };
        let panel = Panel {
            unit: String::new(),
            lines: vec![line("a", gap)],
        };
        let text = chart(&panel, (0.0, 1.0), (60, 5));
        let drawn = text
            .lines()
            .find(|line| line.contains(['⠤', '⠒', '⠉', '⣀']));
        let drawn: Vec<char> = drawn.unwrap().chars().collect();
        assert!(drawn[30..32].iter().all(|c| *c == ' '), "{text}");
    }

    #[test]
    fn lines_of_one_panel_are_told_apart_and_where_they_meet_is_shown() {
        let panel = Panel {
            unit: String::new(),
            lines: vec![
                line("recorded", |at| at),
                line("computed", |at| if at > 0.5 { 0.5 } else { at }),
            ],
        };
        let text = chart(&panel, (0.0, 1.0), (60, 9));
        assert!(
            text.starts_with("o recorded  x computed  # the same\n"),
            "{text}"
        );
        for glyph in ['o', 'x', '#'] {
            assert!(
                text.lines().skip(1).any(|line| line.contains(glyph)),
                "{text}"
            );
        }
    }

    #[test]
    fn nothing_to_draw_is_said() {
        let text = chart(&Panel::default(), (0.0, 1.0), (60, 9));
        assert!(text.contains("no values"), "{text}");
    }
}
