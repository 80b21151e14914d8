//! Panels below each other, as SVG.

use std::fmt::Write as _;

use super::scale::Scale;
use super::{Line, MAX_LINES, Panel};

/// As on the page, but darker; colour-blind people can tell them apart.
const COLOURS: [&str; 8] = [
    "#0b62c4", "#c46a00", "#1b7f4b", "#7b3fb5", "#c9302c", "#0e8a94", "#8a7a00", "#555f6b",
];
/// Pixels.
const WIDTH: f64 = 960.0;
const LEFT: f64 = 72.0;
const RIGHT: f64 = 16.0;
const PLOT_HEIGHT: f64 = 220.0;
const BELOW: f64 = 44.0;
/// A row of the legend, and names in it.
const ROW: f64 = 18.0;
const NAMES_A_ROW: usize = 4;
/// Columns that a line is thinned out to: two for each pixel.
const COLUMNS: usize = 1744;

/// The panels between the times of `span` (s): axes with units, a legend, and for each line
/// one polyline, or several where it is interrupted.
pub fn svg(panels: &[Panel], span: (f64, f64)) -> String {
    let height: f64 = panels.iter().map(panel_height).sum();
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" \
         viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    let mut top = 0.0;
    for panel in panels {
        let _ok = writeln!(out, "<g transform=\"translate(0 {top})\">");
        draw(&mut out, panel, span);
        out.push_str("</g>\n");
        top += panel_height(panel);
    }
    out.push_str("</svg>\n");
    out
}

fn legend_height(panel: &Panel) -> f64 {
    let names = panel.lines.len().min(MAX_LINES);
    ROW * names.div_ceil(NAMES_A_ROW) as f64 + 8.0
}

fn panel_height(panel: &Panel) -> f64 {
    legend_height(panel) + PLOT_HEIGHT + BELOW
}

fn draw(out: &mut String, panel: &Panel, span: (f64, f64)) {
    legend(out, panel);
    let range = panel.range(span).unwrap_or((0.0, 0.0));
    let axes = Axes {
        top: legend_height(panel),
        times: Scale::of(span, 10),
        values: Scale::of(range, 6),
    };
    axes.draw(out, &panel.unit);
    for (index, line) in panel.lines.iter().take(MAX_LINES).enumerate() {
        for part in parts(line, span) {
            let points: Vec<String> = part
                .into_iter()
                .map(|(at, value)| format!("{:.2},{:.2}", axes.x(at), axes.y(value)))
                .collect();
            let _ok = writeln!(
                out,
                "<polyline fill=\"none\" {} stroke-width=\"1.5\" points=\"{}\"/>",
                stroke(index),
                points.join(" ")
            );
        }
    }
}

fn stroke(index: usize) -> String {
    let colour = COLOURS[index % COLOURS.len()];
    let dashes = if index < COLOURS.len() {
        ""
    } else {
        " stroke-dasharray=\"5 3\""
    };
    format!("stroke=\"{colour}\"{dashes}")
}

fn legend(out: &mut String, panel: &Panel) {
    let column = (WIDTH - LEFT - RIGHT) / NAMES_A_ROW as f64;
    for (index, line) in panel.lines.iter().take(MAX_LINES).enumerate() {
        let x = LEFT + column * (index % NAMES_A_ROW) as f64;
        let y = ROW * (index / NAMES_A_ROW) as f64 + 16.0;
        let _ok = writeln!(
            out,
            "<line x1=\"{x}\" x2=\"{}\" y1=\"{}\" y2=\"{}\" {} stroke-width=\"2\"/>\
             <text x=\"{}\" y=\"{y}\">{}</text>",
            x + 18.0,
            y - 4.0,
            y - 4.0,
            stroke(index),
            x + 24.0,
            escaped(&line.name)
        );
    }
}

struct Axes {
    top: f64,
    times: Scale,
    values: Scale,
}

impl Axes {
    fn x(&self, at: f64) -> f64 {
        LEFT + self.times.share(at) * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, value: f64) -> f64 {
        self.top + (1.0 - self.values.share(value)) * PLOT_HEIGHT
    }

    fn draw(&self, out: &mut String, unit: &str) {
        let (right, bottom) = (WIDTH - RIGHT, self.top + PLOT_HEIGHT);
        for mark in self.values.marks() {
            let (y, label) = (self.y(mark), self.values.label(mark));
            let _ok = writeln!(
                out,
                "<line x1=\"{LEFT}\" x2=\"{right}\" y1=\"{y:.2}\" y2=\"{y:.2}\" stroke=\"#dddddd\"/>\
                 <text x=\"{}\" y=\"{:.2}\" text-anchor=\"end\">{label}</text>",
                LEFT - 6.0,
                y + 4.0
            );
        }
        for mark in self.times.marks() {
            let (x, label) = (self.x(mark), self.times.label(mark));
            let _ok = writeln!(
                out,
                "<line x1=\"{x:.2}\" x2=\"{x:.2}\" y1=\"{}\" y2=\"{bottom}\" stroke=\"#dddddd\"/>\
                 <text x=\"{x:.2}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
                self.top,
                bottom + 16.0
            );
        }
        let (middle, centre) = (self.top + PLOT_HEIGHT / 2.0, f64::midpoint(LEFT, right));
        let unit = if unit.is_empty() { "value" } else { unit };
        let _ok = writeln!(
            out,
            "<rect x=\"{LEFT}\" y=\"{}\" width=\"{}\" height=\"{PLOT_HEIGHT}\" fill=\"none\" stroke=\"#333333\"/>\n\
             <text x=\"14\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {middle})\">{}</text>\n\
             <text x=\"{centre}\" y=\"{}\" text-anchor=\"middle\">simulated time (s)</text>",
            self.top,
            right - LEFT,
            escaped(unit),
            bottom + 34.0
        );
    }
}

/// The stretches without a gap, thinned out to what can be seen: of each column the first,
/// the smallest, the largest and the last value.
fn parts(line: &Line, span: (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let column = |at: f64| ((at - span.0) / (span.1 - span.0) * COLUMNS as f64) as usize;
    let (mut parts, mut part, mut bucket) = (Vec::new(), Vec::new(), Vec::new());
    for (at, value) in Panel::within(line, span) {
        let other = bucket
            .first()
            .is_some_and(|(first, _)| column(*first) != column(at));
        if other || !value.is_finite() {
            thin(&mut bucket, &mut part);
        }
        if value.is_finite() {
            bucket.push((at, value));
        } else {
            parts.push(std::mem::take(&mut part));
        }
    }
    thin(&mut bucket, &mut part);
    parts.push(part);
    parts.retain(|part| !part.is_empty());
    parts
}

/// Moves the visible points of `bucket` into `part`.
fn thin(bucket: &mut Vec<(f64, f64)>, part: &mut Vec<(f64, f64)>) {
    let by_value = |a: &(usize, &(f64, f64)), b: &(usize, &(f64, f64))| a.1.1.total_cmp(&b.1.1);
    let least = bucket.iter().enumerate().min_by(by_value);
    let most = bucket.iter().enumerate().max_by(by_value);
    // The extremes keep the peaks; the first and the last value join the line to its neighbours.
    let kept = [
        Some(0),
        least.map(|(at, _)| at),
        most.map(|(at, _)| at),
        bucket.len().checked_sub(1),
    ];
    let mut kept: Vec<usize> = kept.into_iter().flatten().collect();
    kept.sort_unstable();
    kept.dedup();
    part.extend(kept.into_iter().filter_map(|at| bucket.get(at)).copied());
    bucket.clear();
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel() -> Panel {
        let points = (0..10_000).map(|n| (f64::from(n) / 1000.0, f64::from(n % 50)));
        let flat = (0..10).map(|n| (f64::from(n), if n == 5 { f64::NAN } else { 7.0 }));
        Panel {
            unit: "mm".to_owned(),
            lines: vec![
                Line {
                    name: "arm/a <error>".to_owned(),
                    points: points.collect(),
                },
                Line {
                    name: "flat".to_owned(),
                    points: flat.collect(),
                },
            ],
        }
    }

    #[test]
    fn names_units_and_lines_are_in_the_picture() {
        let text = svg(&[panel(), Panel::default()], (0.0, 10.0));
        assert!(text.starts_with("<svg ") && text.ends_with("</svg>\n"));
        for part in [
            "arm/a &lt;error&gt;",
            ">mm<",
            ">simulated time (s)<",
            "flat",
        ] {
            assert!(text.contains(part), "{part}");
        }
        // One of the first line, two of the one with a gap.
        assert_eq!(text.matches("<polyline").count(), 3);
        assert_eq!(text.matches("<g ").count(), text.matches("</g>").count());
        assert!(!text.contains("NaN"), "{text}");
    }

    #[test]
    fn a_long_line_keeps_its_extremes_and_stays_small() {
        let mut line = panel().lines.remove(0);
        line.points[5005].1 = 900.0;
        let parts = parts(&line, (0.0, 10.0));
        assert_eq!(parts.len(), 1);
        assert!(parts[0].len() <= 4 * (COLUMNS + 1), "{}", parts[0].len());
        assert!(parts[0].iter().any(|(_, value)| *value == 900.0));
        assert!(parts[0].is_sorted_by(|a, b| a.0 < b.0));
    }
}
