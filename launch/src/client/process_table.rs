//! The processes of a cell as a table, for `status` and `top`.

use schemars::JsonSchema;
use serde::Serialize;

use super::columns::{Column, table};

/// How a process is doing; without a pid it is silent.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ProcessStatus {
    pub(super) name: String,
    pub(super) pid: Option<u32>,
    /// Which start of the process.
    pub(super) generation: Option<u32>,
    /// `fifo` or `other`.
    pub(super) scheduling: Option<&'static str>,
    pub(super) rate_hz: Option<f64>,
    pub(super) late_p50_us: Option<f64>,
    pub(super) late_p99_us: Option<f64>,
    pub(super) missed_cycles: Option<u64>,
    /// Messages that were refused.
    pub(super) refused: Option<u64>,
    /// Newest trouble in words.
    pub(super) note: Option<String>,
}

const fn column(title: &'static str, rank: u8) -> Column {
    Column {
        title,
        rank,
        text: false,
    }
}

const fn words(title: &'static str, rank: u8) -> Column {
    Column {
        title,
        rank,
        text: true,
    }
}

const COLUMNS: [Column; 10] = [
    words("process", 0),
    column("pid", 3),
    column("start", 4),
    column("rate Hz", 0),
    column("late p50 us", 5),
    column("late p99 us", 1),
    column("missed", 0),
    column("refused", 2),
    words("scheduling", 6),
    words("note", 0),
];

/// The lines, the titles first.
pub(super) fn lines(processes: &[ProcessStatus], width: usize) -> Vec<String> {
    let rows: Vec<Vec<String>> = processes.iter().map(row).collect();
    table(&COLUMNS, &rows, width)
}

fn row(process: &ProcessStatus) -> Vec<String> {
    let count = |value: Option<u64>| value.unwrap_or(0).to_string();
    let figure = |value: Option<f64>| format!("{:.1}", value.unwrap_or(0.0));
    let Some(pid) = process.pid else {
        let mut row = vec![String::new(); COLUMNS.len()];
        row[0].clone_from(&process.name);
        "silent".clone_into(&mut row[COLUMNS.len() - 1]);
        return row;
    };
    vec![
        process.name.clone(),
        pid.to_string(),
        process.generation.unwrap_or(0).to_string(),
        figure(process.rate_hz),
        figure(process.late_p50_us),
        figure(process.late_p99_us),
        count(process.missed_cycles),
        count(process.refused),
        process.scheduling.unwrap_or("-").to_owned(),
        process.note.clone().unwrap_or_default(),
    ]
}
