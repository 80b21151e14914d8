//! `robocell plot`: signals of a recording over time.

mod choose;
mod read;
mod signals;

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

use cell_model::user_file;
use cell_record::Recording;
use evaluation::charts::{Line, Panel};
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::{Context, Failure};

use crate::args::PlotArgs;
use crate::{output, say};
use signals::Signal;

/// Characters of a chart that goes into a pipe or a file.
const COLUMNS: usize = 100;
/// Rows of a chart between its axes.
const ROWS: usize = 12;
const LEAST_ROWS: usize = 6;
/// Rows of a chart beside those between its axes: title, axis, times and a free one.
const OTHER_ROWS: usize = 4;

/// The result of `robocell plot --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Plotted {
    /// The recording.
    #[schemars(with = "String")]
    file: PathBuf,
    /// First simulated time that is plotted.
    from_s: f64,
    /// Last simulated time that is plotted.
    to_s: f64,
    /// The signals asked for; all without samples where none is named.
    signals: Vec<Samples>,
}

/// The samples of a signal.
#[derive(Debug, Serialize, JsonSchema)]
struct Samples {
    /// As in `left/joint1 position`.
    name: String,
    /// Unit of the values; empty for plain numbers.
    unit: &'static str,
    /// Simulated times.
    time_s: Vec<f64>,
    /// As many values; null where there is none, as an error without a target.
    values: Vec<Option<f64>>,
}

impl Samples {
    fn of(signal: &Signal, line: Option<&Line>) -> Self {
        let points = line.map_or(&[][..], |line| &line.points[..]);
        let value = |(_, value): &(f64, f64)| Some(*value).filter(|value| value.is_finite());
        Self {
            name: signal.name.clone(),
            unit: signal.unit,
            time_s: points.iter().map(|(at, _)| *at).collect(),
            values: points.iter().map(value).collect(),
        }
    }
}

/// Does what the command line says.
pub(crate) fn plot(args: &PlotArgs) -> Result<(), Failure> {
    if let Some(out) = &args.output {
        // Before the recording is read, which may take long.
        check_output(out)?;
    }
    let recording = Recording::open(&args.file).map_err(Failure::configuration)?;
    let all = signals::signals(recording.scene());
    let span = span(args, recording.span_s())?;
    // A picture has as many colours and marks as can be told apart; numbers need none.
    let is_picture = !args.json || args.output.is_some();
    let most = if is_picture {
        evaluation::charts::MAX_LINES
    } else {
        usize::MAX
    };
    let chosen = choose::choose(&all, &args.signals, most)?;
    if chosen.is_empty() {
        return list(args, &all, span);
    }
    let lines = read::lines(&recording, &chosen, span).map_err(Failure::configuration)?;
    if lines.iter().all(|line| line.points.is_empty()) {
        return Err(Failure::configuration(format!(
            "{}: no whole state is recorded from {:.3} s to {:.3} s; choose a longer time with `--from` and `--to`",
            args.file.display(),
            span.0,
            span.1
        )));
    }
    if args.json {
        let samples = chosen.iter().zip(&lines);
        let samples = samples.map(|(signal, line)| Samples::of(signal, Some(line)));
        return print_json(args, span, samples.collect());
    }
    if let Some(out) = &args.output {
        let picture = evaluation::charts::svg(&by_unit(&chosen, &lines), span);
        std::fs::write(out, picture).cannot(format!("write {}", out.display()))?;
    }
    if args.output.is_none() {
        print_text(&chosen, lines, span);
    }
    Ok(())
}

fn check_output(out: &Path) -> Result<(), Failure> {
    if out.extension().is_some_and(|end| end == "svg") {
        return user_file::check_output(out).cannot(format!("write {}", out.display()));
    }
    Err(Failure::usage(format!(
        "--output {}: only SVG is written; give a name that ends in .svg",
        out.display()
    )))
}

/// The part of the recorded time that is plotted.
fn span(args: &PlotArgs, (first, last): (f64, f64)) -> Result<(f64, f64), Failure> {
    let (from, to) = (args.from.unwrap_or(first), args.to.unwrap_or(last));
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from >= to
    {
        return Err(Failure::usage(format!(
            "--from {from} --to {to}: the first time has to be before the last one"
        )));
    }
    let span = (from.max(first), to.min(last));
    if span.0 >= span.1 {
        return Err(Failure::configuration(format!(
            "{}: nothing is recorded from {from:.3} s to {to:.3} s; there is {first:.3} s to {last:.3} s",
            args.file.display()
        )));
    }
    Ok(span)
}

/// The signals there are.
fn list(args: &PlotArgs, all: &[Signal], span: (f64, f64)) -> Result<(), Failure> {
    if args.output.is_some() {
        return Err(Failure::usage(
            "no signal is named; `robocell plot FILE` lists them",
        ));
    }
    if args.json {
        let samples = all.iter().map(|signal| Samples::of(signal, None));
        return print_json(args, span, samples.collect());
    }
    let widest = all.iter().map(|signal| signal.name.chars().count()).max();
    let width = widest.unwrap_or(0);
    for signal in all {
        let line = format!("{:width$}  {}", signal.name, signal.unit);
        say::line(line.trim_end());
    }
    Ok(())
}

fn print_json(args: &PlotArgs, span: (f64, f64), signals: Vec<Samples>) -> Result<(), Failure> {
    output::print(&Plotted {
        file: args.file.clone(),
        from_s: span.0,
        to_s: span.1,
        signals,
    })
}

/// One chart for each signal: characters have no colours to tell lines apart.
fn print_text(signals: &[Signal], lines: Vec<Line>, span: (f64, f64)) {
    let is_finite = |(_, value): &(f64, f64)| value.is_finite();
    let with_values = |line: &Line| line.points.iter().any(is_finite);
    let (drawn, empty): (Vec<_>, Vec<_>) = signals
        .iter()
        .zip(lines)
        .partition(|(_, line)| with_values(line));
    let (columns, rows) = size(drawn.len());
    for (index, (signal, line)) in drawn.into_iter().enumerate() {
        let panel = Panel {
            unit: signal.unit.to_owned(),
            lines: vec![line],
        };
        if index > 0 {
            say::line("");
        }
        say::raw(evaluation::charts::chart(&panel, span, (columns, rows)).as_bytes());
    }
    for (signal, _) in empty {
        say::line(format_args!("{}: no values in this time", signal.name));
    }
}

/// Columns and rows of each of so many charts: all of them on one screen, if they fit.
fn size(charts: usize) -> (usize, usize) {
    let terminal = std::io::stdout()
        .is_terminal()
        .then(crossterm::terminal::size);
    let Some(Ok((columns, rows))) = terminal else {
        return (COLUMNS, ROWS);
    };
    // One row is left for the prompt.
    let each = usize::from(rows).saturating_sub(1) / charts.max(1);
    let rows = each.saturating_sub(OTHER_ROWS).max(LEAST_ROWS);
    (usize::from(columns), rows)
}

/// Signals of one unit share axes.
fn by_unit(signals: &[Signal], lines: &[Line]) -> Vec<Panel> {
    let mut panels: Vec<Panel> = Vec::new();
    for (signal, line) in signals.iter().zip(lines) {
        match panels.iter_mut().find(|panel| panel.unit == signal.unit) {
            Some(panel) => panel.lines.push(line.clone()),
            None => panels.push(Panel {
                unit: signal.unit.to_owned(),
                lines: vec![line.clone()],
            }),
        }
    }
    panels
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use supervisor::failure::Code;

    fn args(from: Option<f64>, to: Option<f64>) -> PlotArgs {
        PlotArgs {
            file: "a.mcap".into(),
            signals: Vec::new(),
            from,
            to,
            output: None,
            json: false,
        }
    }

    #[test]
    fn the_span_is_what_is_recorded_of_what_is_asked_for() {
        let recorded = (1.0, 9.0);
        assert_eq!(span(&args(None, None), recorded).unwrap(), (1.0, 9.0));
        assert_eq!(
            span(&args(Some(0.0), Some(4.0)), recorded).unwrap(),
            (1.0, 4.0)
        );
        let outside = span(&args(Some(10.0), None), recorded).unwrap_err();
        assert_eq!(outside.code, Code::Configuration);
        assert!(outside.message.contains("1.000 s to 9.000 s"), "{outside}");
        let swapped = span(&args(Some(5.0), Some(2.0)), recorded).unwrap_err();
        assert_eq!(swapped.code, Code::Usage);
    }

    #[test]
    fn signals_of_one_unit_share_a_panel() {
        let scene = json!({ "arms": [{ "name": "a", "joints": [{ "name": "j1" }] }] });
        let all = signals::signals(&scene);
        let asked = ["a/j1 error", "a/TCP x", "a/j1 position"].map(str::to_owned);
        let chosen = choose::choose(&all, &asked, evaluation::charts::MAX_LINES).unwrap();
        let lines = vec![Line::default(); 3];
        let panels = by_unit(&chosen, &lines);
        let counts: Vec<_> = panels
            .iter()
            .map(|p| (p.unit.as_str(), p.lines.len()))
            .collect();
        assert_eq!(counts, [("°", 2), ("m", 1)]);
    }
}
