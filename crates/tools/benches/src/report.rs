//! Output of a bench: rows of one run, as a table or as one JSON object.

use std::io::{self, Write};

use schemars::JsonSchema;
use serde::Serialize;

/// Characters of a line with a histogram; the table above it is as wide.
const COLUMNS: usize = 100;

/// Durations in nanoseconds, all of them: percentiles are exact.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples(Vec<u64>);

impl Samples {
    /// With room for `count`, so that recording does not allocate.
    pub(crate) fn with_capacity(count: usize) -> Self {
        Self(Vec::with_capacity(count))
    }

    /// Adds one duration (ns).
    pub(crate) fn record(&mut self, duration_ns: u64) {
        self.0.push(duration_ns);
    }

    /// Adds durations (ns).
    pub(crate) fn record_all(&mut self, durations_ns: &[u64]) {
        self.0.extend(durations_ns);
    }

    /// Number of durations.
    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// The durations in microseconds, in the order they were added.
    pub(crate) fn micros(&self) -> Vec<f64> {
        self.0.iter().map(|ns| *ns as f64 / 1000.0).collect()
    }

    /// The row of these durations, in microseconds.
    pub(crate) fn into_row(self, name: String) -> Row {
        Row::of(name, self.micros(), "us")
    }
}

/// One line of a bench.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct Row {
    /// What was measured.
    pub(crate) name: String,
    /// Samples.
    pub(crate) n: usize,
    /// Median.
    pub(crate) p50: f64,
    /// 99th percentile.
    pub(crate) p99: f64,
    /// 99.9th percentile.
    pub(crate) p999: f64,
    /// Largest.
    pub(crate) max: f64,
    /// Unit of the four.
    pub(crate) unit: &'static str,
    /// p50 over the p50 of the row `against`.
    pub(crate) ratio: Option<f64>,
    /// Name of the row this one is held against.
    pub(crate) against: Option<String>,
    /// The same for p99.
    pub(crate) ratio_p99: Option<f64>,
    /// The same for p99.9.
    pub(crate) ratio_p999: Option<f64>,
}

impl Row {
    /// A row in microseconds without comparison; `figures` are p50, p99, p99.9 and the maximum.
    pub(crate) fn new(name: String, n: usize, [p50, p99, p999, max]: [f64; 4]) -> Self {
        Self {
            name,
            n,
            p50,
            p99,
            p999,
            max,
            unit: "us",
            ratio: None,
            against: None,
            ratio_p99: None,
            ratio_p999: None,
        }
    }

    /// The row of all of these values; without values its figures are 0.
    pub(crate) fn of(name: String, mut values: Vec<f64>, unit: &'static str) -> Self {
        values.sort_unstable_by(f64::total_cmp);
        let at = |permille: usize| {
            // The smallest value that so many do not exceed.
            let rank = (values.len() * permille).div_ceil(1000).max(1) - 1;
            values.get(rank).copied().unwrap_or(0.0)
        };
        let figures = [at(500), at(990), at(999), at(1000)];
        Self::new(name, values.len(), figures).in_unit(unit)
    }

    /// A row of one value.
    pub(crate) fn single(name: &str, value: f64, unit: &'static str) -> Self {
        Self::of(name.to_owned(), vec![value], unit)
    }

    /// The same figures, in this unit.
    #[must_use]
    pub(crate) fn in_unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }
}

/// All rows of one run.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Report {
    /// Name of the bench.
    pub(crate) bench: &'static str,
    /// Scheduling that was granted: `fifo` or `other`.
    pub(crate) scheduling: &'static str,
    /// What a reader has to know to understand the rows.
    pub(crate) notes: Vec<String>,
    /// The rows.
    pub(crate) rows: Vec<Row>,
    /// Names and durations (us) of the histograms below the table.
    #[serde(skip)]
    pub(crate) histograms: Vec<(String, Vec<f64>)>,
}

impl Report {
    /// A report without rows. `refused`: what the system did not grant.
    pub(crate) fn new(bench: &'static str, fifo: bool, refused: &[String]) -> Self {
        Self {
            bench,
            scheduling: if fifo { "fifo" } else { "other" },
            notes: refused.to_vec(),
            rows: Vec::new(),
            histograms: Vec::new(),
        }
    }

    /// Adds a note that several rows have in common.
    pub(crate) fn note_once(&mut self, note: &str) {
        if !self.notes.iter().any(|known| known == note) {
            self.notes.push(note.to_owned());
        }
    }

    /// Draws these durations below the table.
    pub(crate) fn draw(&mut self, name: &str, samples: &Samples) {
        self.histograms.push((name.to_owned(), samples.micros()));
    }

    /// Compares the row `name` with the row `base`.
    pub(crate) fn compare(&mut self, name: &str, base: &str) {
        // A row of a program that is not installed is missing: nothing to compare with.
        let Some(base) = self.rows.iter().find(|row| row.name == base).cloned() else {
            return;
        };
        let Some(row) = self.rows.iter_mut().find(|row| row.name == name) else {
            return;
        };
        // Without a ratio rather than an infinite one.
        let ratio = |a: f64, b: f64| (b > 0.0).then(|| a / b);
        row.ratio = ratio(row.p50, base.p50);
        row.ratio_p99 = ratio(row.p99, base.p99);
        row.ratio_p999 = ratio(row.p999, base.p999);
        row.against = Some(base.name);
    }

    /// Writes a table, or one JSON object on the last line.
    ///
    /// # Errors
    ///
    /// When `out` refuses it.
    pub(crate) fn write(&self, out: &mut impl Write, json: bool) -> io::Result<()> {
        if json {
            return writeln!(out, "{}", serde_json::to_string(self)?);
        }
        // A single unit is named once, several behind each figure.
        let unit = self.rows.first().map_or("us", |row| row.unit);
        let mixed = self.rows.iter().any(|row| row.unit != unit);
        let units = if mixed {
            "units behind the figures".to_owned()
        } else {
            format!("times in {unit}")
        };
        writeln!(
            out,
            "{}: scheduling {}, {units}",
            self.bench, self.scheduling
        )?;
        for note in &self.notes {
            writeln!(out, "  {note}")?;
        }
        writeln!(
            out,
            "{:<42} {:>7} {:>9} {:>9} {:>9} {:>9}  {:>7}  against",
            "", "n", "p50", "p99", "p99.9", "max", "ratio"
        )?;
        for row in &self.rows {
            let ratio = row.ratio.map(|ratio| format!("{ratio:.3}"));
            let ratio = ratio.unwrap_or_default();
            let unit = if mixed { row.unit } else { "" };
            writeln!(
                out,
                "{:<42} {:>7} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {unit} {ratio:>7}  {}",
                row.name,
                row.n,
                row.p50,
                row.p99,
                row.p999,
                row.max,
                row.against.as_deref().unwrap_or("")
            )?;
        }
        self.write_histograms(out)
    }

    fn write_histograms(&self, out: &mut impl Write) -> io::Result<()> {
        for (name, micros) in &self.histograms {
            let drawn = evaluation::charts::histogram(name, "us", micros, COLUMNS);
            write!(out, "\n{drawn}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, values: impl Iterator<Item = u64>) -> Row {
        let mut samples = Samples::with_capacity(0);
        values.for_each(|value| samples.record(value));
        samples.into_row(name.to_owned())
    }

    #[test]
    fn percentiles_are_ranks() {
        let row = row("a", (1..=1000).rev().map(|value| value * 1000));
        assert_eq!(
            (row.p50, row.p99, row.p999, row.max),
            (500.0, 990.0, 999.0, 1000.0)
        );
        assert_eq!(self::row("none", std::iter::empty()).p50, 0.0);
    }

    #[test]
    fn rows_of_several_units_say_theirs() {
        let mut report = Report::new("behavior", false, &[]);
        let text = |report: &Report| {
            let mut out = Vec::new();
            report.write(&mut out, false).unwrap();
            String::from_utf8(out).unwrap()
        };
        report.rows = vec![row("a tick", [2000].into_iter())];
        assert!(text(&report).contains("times in us"));
        let counted = row("a tick", [0].into_iter()).in_unit("allocations");
        report.rows.push(counted);
        let table = text(&report);
        assert!(table.contains("2.00 us ") && table.contains("0.00 allocations "));
    }

    #[test]
    fn a_histogram_is_drawn_below_the_table_and_is_not_in_the_json() {
        let mut samples = Samples::with_capacity(0);
        for ns in [3_000, 4_000, 700_000] {
            samples.record(ns);
        }
        let mut report = Report::new("loop", false, &[]);
        report.draw("grid", &samples);
        let text = |json: bool| {
            let mut out = Vec::new();
            report.write(&mut out, json).unwrap();
            String::from_utf8(out).unwrap()
        };
        let drawn = text(false);
        let head = "\ngrid: 3 values, p50 4.00 us, p99 700.00 us, max 700.00 us\n";
        assert!(drawn.contains(head) && drawn.contains('█'), "{drawn}");
        assert!(!text(true).contains("histogram"));
    }

    #[test]
    fn the_json_has_what_scripts_read() {
        let mut report = Report::new("ipc", true, &[]);
        report.rows = vec![
            row("base", [2000].into_iter()),
            row("ours", [3000].into_iter()),
        ];
        report.compare("ours", "base");
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(
            (&json["bench"], &json["scheduling"]),
            (&"ipc".into(), &"fifo".into())
        );
        assert_eq!(json["rows"][0]["ratio"], serde_json::Value::Null);
        assert_eq!(json["rows"][1]["ratio"], 1.5);
        assert_eq!(json["rows"][1]["against"], "base");
        for key in ["name", "n", "p50", "p99", "p999", "max", "unit"] {
            assert!(json["rows"][1].get(key).is_some(), "{key}");
        }
    }
}
