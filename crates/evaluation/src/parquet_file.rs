//! Rows as a Parquet file.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;

use crate::EvaluationError;
use crate::columns::{COLUMNS, schema};
use crate::row::Row;

/// Rows of a row group. They are in memory until it is written.
const GROUP: usize = 16_384;

/// A Parquet file that is written. It has a column for each key of a row.
pub struct ParquetFile {
    path: PathBuf,
    writer: SerializedFileWriter<File>,
    /// Rows of the next row group.
    rows: Vec<Row>,
}

impl ParquetFile {
    /// Creates the file at `path`, or replaces it.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn create(path: &Path) -> Result<Self, EvaluationError> {
        let file = File::create(path).map_err(EvaluationError::io(path))?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
        let writer = schema(&COLUMNS).and_then(|schema| {
            SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build()))
        });
        Ok(Self {
            path: path.to_owned(),
            writer: or_error(path, writer)?,
            rows: Vec::new(),
        })
    }

    /// Appends a row.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn append(&mut self, row: Row) -> Result<(), EvaluationError> {
        self.rows.push(row);
        if self.rows.len() < GROUP {
            return Ok(());
        }
        self.write_group()
    }

    /// Writes the rows of the last group and the footer, without which the file cannot be read.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn finish(mut self) -> Result<(), EvaluationError> {
        if !self.rows.is_empty() {
            self.write_group()?;
        }
        or_error(&self.path, self.writer.close())?;
        Ok(())
    }

    fn write_group(&mut self) -> Result<(), EvaluationError> {
        let written = write_group(&mut self.writer, &self.rows);
        or_error(&self.path, written)?;
        self.rows.clear();
        Ok(())
    }
}

fn write_group(writer: &mut SerializedFileWriter<File>, rows: &[Row]) -> Result<()> {
    let mut group = writer.next_row_group()?;
    for column in &COLUMNS {
        // The schema has as many columns as the table.
        let Some(mut to) = group.next_column()? else {
            break;
        };
        column.write(rows, &mut to)?;
        to.close()?;
    }
    group.close()?;
    Ok(())
}

fn or_error<T>(path: &Path, result: Result<T>) -> Result<T, EvaluationError> {
    let result = result.map_err(|error| match error {
        // Of the file system.
        ParquetError::External(source) => std::io::Error::other(source),
        error => std::io::Error::other(error),
    });
    result.map_err(EvaluationError::io(path))
}
