//! Rows as a Parquet file, read back by the reader of the package.

use std::fs::{self, File};
use std::path::Path;

use evaluation::merge::merge_lines;
use evaluation::parquet_file::ParquetFile;
use evaluation::row::{Row, RowOutcome};
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::{case, identity, shards};

/// Rows of all outcomes. Numbers are at the ends of their ranges, some texts are not ASCII.
fn rows() -> Vec<Row> {
    let error = Row::error(
        &identity(),
        ("cube", "fsm"),
        &case(0),
        "Würfel „a“ 🦀".to_owned(),
    );
    let of = |seed, outcome, reason: Option<&str>, placed: &[&str]| Row {
        seed,
        outcome,
        reason: reason.map(str::to_owned),
        sim_time_s: 0.1 + f64::from(u8::from(outcome == RowOutcome::Done)),
        placed: placed.iter().map(|&name| name.to_owned()).collect(),
        state_hash: "00ff00ff00ff00ff".to_owned(),
        ..error.clone()
    };
    let mut most = of(u64::MAX, RowOutcome::Done, None, &["ä", "", "箱"]);
    most.ticks = u64::MAX;
    most.drops = u32::MAX;
    most.self_contacts = 1 << 63;
    most.variant = 2;
    most.drawn
        .insert("object.cube.mass_kg".to_owned(), 7.into());
    most.set.insert("task.timeout_s".to_owned(), 4.into());
    vec![
        error.clone(),
        of(1, RowOutcome::Failed, Some(""), &[]),
        of(2, RowOutcome::Timeout, None, &["cube"]),
        of(3, RowOutcome::Done, None, &[]),
        most,
    ]
}

/// A value of a row in JSON as its column has it: an object is its text.
fn in_column(value: &Value) -> Value {
    match value {
        Value::Object(_) => json!(value.to_string()),
        value => value.clone(),
    }
}

fn value(field: &Field) -> Value {
    match field {
        Field::Null => Value::Null,
        Field::Str(text) => json!(text),
        Field::UInt(number) => json!(number),
        Field::ULong(number) => json!(number),
        Field::Double(number) => json!(number),
        Field::ListInternal(list) => list.elements().iter().map(value).collect(),
        // Equal to no value of a row.
        other => json!({"type of another column": other.to_string()}),
    }
}

fn read(path: &Path) -> (Vec<serde_json::Map<String, Value>>, usize) {
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let groups = reader.num_row_groups();
    let rows = reader.get_row_iter(None).unwrap().map(|row| {
        let row = row.unwrap();
        row.get_column_iter()
            .map(|(name, field)| (name.clone(), value(field)))
            .collect()
    });
    (rows.collect(), groups)
}

fn assert_same(columns: &serde_json::Map<String, Value>, row: &Value) {
    for (name, value) in columns {
        let expected = match &row[name] {
            // A row without has no variant.
            Value::Null if name == "variant" => json!(0),
            other => in_column(other),
        };
        assert_eq!(*value, expected, "{name}");
    }
    for name in row.as_object().unwrap().keys() {
        assert!(columns.contains_key(name), "{name} has no column");
    }
}

#[test]
fn rows_of_all_outcomes_are_read_back_from_a_parquet_file() {
    let dir = TempDir::new().unwrap();
    let path = dir.path().join("rows.parquet");
    let mut file = ParquetFile::create(&path).unwrap();
    for row in rows() {
        file.append(row).unwrap();
    }
    file.finish().unwrap();
    // Columns are in the order of the keys.
    let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
    let schema = reader.metadata().file_metadata().schema();
    let names = schema.get_fields().iter().map(|field| field.name());
    // The last row has all keys.
    let text = serde_json::to_string(&rows()[4]).unwrap();
    let places = names.map(|name| text.find(&format!("\"{name}\":")).expect(name));
    assert!(places.is_sorted());
    let (read, groups) = read(&path);
    assert_eq!((read.len(), groups), (5, 1));
    for (columns, row) in read.iter().zip(rows()) {
        assert_same(columns, &serde_json::to_value(row).unwrap());
    }
}

#[test]
fn merged_rows_are_written_in_groups_in_the_order_of_their_seeds() {
    let dir = TempDir::new().unwrap();
    let files = shards(&dir, [1, 40_000], 3);
    let path = dir.path().join("rows.parquet");
    let mut file = ParquetFile::create(&path).unwrap();
    let merged = merge_lines(&files, &mut |line| file.append(line.row()?)).unwrap();
    file.finish().unwrap();
    let (read, groups) = read(&path);
    assert_eq!((merged.rows, read.len(), groups), (40_000, 40_000, 3));
    assert!(
        (1..)
            .zip(&read)
            .all(|(seed, row)| row["seed"] == json!(seed))
    );
}

#[test]
fn no_rows_are_a_file_with_columns() {
    let dir = TempDir::new().unwrap();
    let path = dir.path().join("rows.parquet");
    ParquetFile::create(&path).unwrap().finish().unwrap();
    assert_eq!(read(&path), (Vec::new(), 0));
    assert!(fs::metadata(&path).unwrap().len() > 0);
    let error = ParquetFile::create(dir.path()).err().unwrap().to_string();
    assert!(error.contains(&dir.path().display().to_string()), "{error}");
}
