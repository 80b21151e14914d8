//! Columns of rows in a Parquet file: names, types and values.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write as _;

use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type, Int64Type};
use parquet::errors::Result;
use parquet::file::writer::SerializedColumnWriter;
use parquet::schema::parser::parse_message_type;
use parquet::schema::types::Type;
use serde_json::Number;

use crate::row::{Row, RowOutcome};

/// A column, with what reads its value from a row.
pub(crate) struct Column {
    name: &'static str,
    values: Values,
}

enum Values {
    Text(fn(&Row) -> &str),
    /// Null where there is none.
    OptionalText(fn(&Row) -> Option<Cow<'_, str>>),
    Texts(fn(&Row) -> &[String]),
    U32(fn(&Row) -> u32),
    U64(fn(&Row) -> u64),
    F64(fn(&Row) -> f64),
}

/// All keys of a row, in its order.
pub(crate) const COLUMNS: [Column; 24] = {
    use Values::{F64, OptionalText, Text, Texts, U32, U64};
    [
        column("demo", Text(|row| &row.demo)),
        column("policy", Text(|row| &row.policy)),
        column("build", Text(|row| &row.build)),
        column("inputs", Text(|row| &row.inputs)),
        column("seed", U64(|row| row.seed)),
        column("variant", U32(|row| row.variant)),
        column("set", OptionalText(|row| object(&row.set))),
        column("drawn", OptionalText(|row| object(&row.drawn))),
        column("outcome", Text(|row| outcome(row.outcome))),
        column(
            "reason",
            OptionalText(|row| row.reason.as_deref().map(Cow::Borrowed)),
        ),
        column(
            "message",
            OptionalText(|row| row.message.as_deref().map(Cow::Borrowed)),
        ),
        column("sim_time_s", F64(|row| row.sim_time_s)),
        column("ticks", U64(|row| row.ticks)),
        column("placed", Texts(|row| &row.placed)),
        column("drops", U32(|row| row.drops)),
        column("resyncs", U32(|row| row.resyncs)),
        column("aborts", U32(|row| row.aborts)),
        column("recoveries", U32(|row| row.recoveries)),
        column("task_restarts", U32(|row| row.task_restarts)),
        column("limit_violations", U64(|row| row.limit_violations)),
        column("obstacle_contacts", U64(|row| row.obstacle_contacts)),
        column("self_contacts", U64(|row| row.self_contacts)),
        column("script_left", U32(|row| row.script_left)),
        column("state_hash", Text(|row| &row.state_hash)),
    ]
};

const fn column(name: &'static str, values: Values) -> Column {
    Column { name, values }
}

/// Numbers by key as JSON; none without any.
fn object(numbers: &BTreeMap<String, Number>) -> Option<Cow<'_, str>> {
    let text = serde_json::to_string(numbers).ok();
    text.filter(|_| !numbers.is_empty()).map(Cow::Owned)
}

/// As in JSON.
fn outcome(outcome: RowOutcome) -> &'static str {
    match outcome {
        RowOutcome::Done => "done",
        RowOutcome::Failed => "failed",
        RowOutcome::Timeout => "timeout",
        RowOutcome::Error => "error",
    }
}

/// The schema of a file with these columns.
pub(crate) fn schema(columns: &[Column]) -> Result<Type> {
    let mut text = "message row {\n".to_owned();
    for Column { name, values } in columns {
        let written = match values {
            Values::Text(_) => writeln!(text, "required binary {name} (STRING);"),
            Values::OptionalText(_) => writeln!(text, "optional binary {name} (STRING);"),
            Values::Texts(_) => writeln!(
                text,
                "required group {name} (LIST) {{ repeated group list {{ required binary element \
                 (STRING); }} }}"
            ),
            Values::U32(_) => writeln!(text, "required int32 {name} (INTEGER(32,false));"),
            Values::U64(_) => writeln!(text, "required int64 {name} (INTEGER(64,false));"),
            Values::F64(_) => writeln!(text, "required double {name};"),
        };
        written.map_err(|error| parquet::errors::ParquetError::External(error.into()))?;
    }
    text.push('}');
    parse_message_type(&text)
}

impl Column {
    /// Writes the values of `rows`.
    pub(crate) fn write(&self, rows: &[Row], to: &mut SerializedColumnWriter<'_>) -> Result<()> {
        match &self.values {
            Values::Text(of) => {
                let values: Vec<ByteArray> = rows.iter().map(|row| bytes(of(row))).collect();
                to.typed::<ByteArrayType>()
                    .write_batch(&values, None, None)?;
            }
            Values::OptionalText(of) => {
                let texts: Vec<Option<Cow<'_, str>>> = rows.iter().map(of).collect();
                let levels: Vec<i16> = texts.iter().map(|text| text.is_some().into()).collect();
                let values: Vec<ByteArray> =
                    texts.iter().flatten().map(|text| bytes(text)).collect();
                to.typed::<ByteArrayType>()
                    .write_batch(&values, Some(&levels), None)?;
            }
            Values::Texts(of) => write_lists(rows.iter().map(of), to)?,
            Values::U32(of) => {
                let values: Vec<i32> = rows.iter().map(|row| of(row).cast_signed()).collect();
                to.typed::<Int32Type>().write_batch(&values, None, None)?;
            }
            Values::U64(of) => {
                let values: Vec<i64> = rows.iter().map(|row| of(row).cast_signed()).collect();
                to.typed::<Int64Type>().write_batch(&values, None, None)?;
            }
            Values::F64(of) => {
                let values: Vec<f64> = rows.iter().map(of).collect();
                to.typed::<DoubleType>().write_batch(&values, None, None)?;
            }
        }
        Ok(())
    }
}

/// An empty list has one entry of level 0, without a value. Repetition level 0 begins a list.
fn write_lists<'a>(
    lists: impl Iterator<Item = &'a [String]>,
    to: &mut SerializedColumnWriter<'_>,
) -> Result<()> {
    let (mut values, mut defined, mut repeated) = (Vec::new(), Vec::new(), Vec::new());
    for list in lists {
        if list.is_empty() {
            defined.push(0);
            repeated.push(0);
        }
        for (index, text) in list.iter().enumerate() {
            values.push(bytes(text));
            defined.push(1);
            repeated.push(i16::from(index > 0));
        }
    }
    to.typed::<ByteArrayType>()
        .write_batch(&values, Some(&defined), Some(&repeated))?;
    Ok(())
}

fn bytes(text: &str) -> ByteArray {
    ByteArray::from(text)
}
