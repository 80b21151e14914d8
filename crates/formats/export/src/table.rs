//! Tables in files of Parquet.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use crate::ExportError;

/// The values of a column, one row after the other.
pub(crate) enum Values {
    Int(Vec<i64>),
    Float(Vec<f32>),
    Double(Vec<f64>),
    Bool(Vec<bool>),
    Text(Vec<String>),
    /// Pictures: bytes of a PNG each.
    Pictures(Vec<Vec<u8>>),
}

/// A column.
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) values: Values,
    /// Values of a row, and the depth of their lists; `None` for single values. Only the outer
    /// list has more than one entry.
    pub(crate) list: Option<(usize, i16)>,
}

impl Column {
    /// A value in each row.
    pub(crate) fn one(name: &str, values: Values) -> Self {
        let name = name.to_owned();
        Self {
            name,
            values,
            list: None,
        }
    }

    /// A list of `width` values in each row.
    pub(crate) fn list(name: &str, width: usize, values: Values) -> Self {
        Self {
            list: Some((width, 1)),
            ..Self::one(name, values)
        }
    }

    /// Lists of one value inside lists of one value inside a list of `width`.
    pub(crate) fn nested(name: &str, width: usize, values: Values) -> Self {
        Self {
            list: Some((width, 3)),
            ..Self::one(name, values)
        }
    }

    fn count(&self) -> usize {
        match &self.values {
            Values::Int(all) => all.len(),
            Values::Float(all) => all.len(),
            Values::Double(all) => all.len(),
            Values::Bool(all) => all.len(),
            Values::Text(all) => all.len(),
            Values::Pictures(all) => all.len(),
        }
    }

    fn to_type(&self) -> Result<TypePtr, ParquetError> {
        if matches!(self.values, Values::Pictures(_)) {
            // The struct of the feature `Image` of the package `datasets`, by which lerobot reads
            // pictures.
            let bytes = leaf("bytes", Physical::BYTE_ARRAY, None)?;
            let path = leaf("path", Physical::BYTE_ARRAY, Some(LogicalType::String))?;
            return group(&self.name, vec![bytes, path]);
        }
        let (physical, logical) = match &self.values {
            Values::Int(_) => (Physical::INT64, None),
            Values::Float(_) => (Physical::FLOAT, None),
            Values::Double(_) => (Physical::DOUBLE, None),
            Values::Bool(_) => (Physical::BOOLEAN, None),
            Values::Text(_) | Values::Pictures(_) => {
                (Physical::BYTE_ARRAY, Some(LogicalType::String))
            }
        };
        let Some((_, depth)) = self.list else {
            return leaf(&self.name, physical, logical);
        };
        let mut inner = leaf("element", physical, logical)?;
        for level in (0..depth).rev() {
            let name = if level == 0 { &self.name } else { "element" };
            inner = list_of(name, inner)?;
        }
        Ok(inner)
    }

    /// Levels of definition and of repetition, where there are lists.
    fn levels(&self) -> Option<(Vec<i16>, Vec<i16>)> {
        let (width, depth) = self.list?;
        let count = self.count();
        // A new row, or another entry of the outer list.
        let repeated = (0..count).map(|at| i16::from(!at.is_multiple_of(width.max(1))));
        // No value is missing, so the level of definition is the highest: one for each list, since
        // everything else is required.
        Some((vec![depth; count], repeated.collect()))
    }

    fn write(&self, writer: &mut ColumnWriter<'_>, is_path: bool) -> Result<(), ParquetError> {
        let levels = self.levels();
        let (defined, repeated) = match &levels {
            Some((defined, repeated)) => (Some(defined.as_slice()), Some(repeated.as_slice())),
            None => (None, None),
        };
        let bytes: Vec<ByteArray>;
        match (writer, &self.values) {
            (ColumnWriter::Int64ColumnWriter(to), Values::Int(all)) => {
                to.write_batch(all, defined, repeated)?;
            }
            (ColumnWriter::FloatColumnWriter(to), Values::Float(all)) => {
                to.write_batch(all, defined, repeated)?;
            }
            (ColumnWriter::DoubleColumnWriter(to), Values::Double(all)) => {
                to.write_batch(all, defined, repeated)?;
            }
            (ColumnWriter::BoolColumnWriter(to), Values::Bool(all)) => {
                to.write_batch(all, defined, repeated)?;
            }
            (ColumnWriter::ByteArrayColumnWriter(to), Values::Text(all)) => {
                bytes = all.iter().map(|text| text.as_str().into()).collect();
                to.write_batch(&bytes, defined, repeated)?;
            }
            (ColumnWriter::ByteArrayColumnWriter(to), Values::Pictures(all)) => {
                // The bytes are in the file, so that a path names nothing.
                bytes = all
                    .iter()
                    .map(|png| {
                        if is_path {
                            "".into()
                        } else {
                            png.clone().into()
                        }
                    })
                    .collect();
                to.write_batch(&bytes, defined, repeated)?;
            }
            _ => return Err(ParquetError::General("a column of another type".to_owned())),
        }
        Ok(())
    }
}

fn leaf(
    name: &str,
    physical: Physical,
    logical: Option<LogicalType>,
) -> Result<TypePtr, ParquetError> {
    let leaf = Type::primitive_type_builder(name, physical);
    let leaf = leaf.with_repetition(Repetition::REQUIRED);
    Ok(Arc::new(leaf.with_logical_type(logical).build()?))
}

fn group(name: &str, fields: Vec<TypePtr>) -> Result<TypePtr, ParquetError> {
    let group = Type::group_type_builder(name).with_repetition(Repetition::REQUIRED);
    Ok(Arc::new(group.with_fields(fields).build()?))
}

fn list_of(name: &str, element: TypePtr) -> Result<TypePtr, ParquetError> {
    // The three levels, and the names, that the specification of Parquet gives a list.
    let entries = Type::group_type_builder("list").with_repetition(Repetition::REPEATED);
    let entries = Arc::new(entries.with_fields(vec![element]).build()?);
    let list = Type::group_type_builder(name).with_repetition(Repetition::REQUIRED);
    let list = list.with_logical_type(Some(LogicalType::List));
    let list = list.with_converted_type(ConvertedType::LIST);
    Ok(Arc::new(list.with_fields(vec![entries]).build()?))
}

/// A file that grows by groups of rows.
pub(crate) struct TableFile {
    writer: SerializedFileWriter<File>,
    path: PathBuf,
}

impl TableFile {
    /// A file for rows of these columns.
    pub(crate) fn create(path: &Path, columns: &[Column]) -> Result<Self, ExportError> {
        let cannot = |error: ParquetError| ExportError::table(path, error);
        let fields: Result<Vec<_>, _> = columns.iter().map(Column::to_type).collect();
        let schema = fields
            .and_then(|fields| group("schema", fields))
            .map_err(cannot)?;
        if let Some(dir) = path.parent() {
            std::fs::create_dir_all(dir).map_err(|error| ExportError::io(dir, error))?;
        }
        let file = File::create(path).map_err(|error| ExportError::io(path, error))?;
        let properties = Arc::new(WriterProperties::new());
        let writer = SerializedFileWriter::new(file, schema, properties).map_err(cannot)?;
        Ok(Self {
            writer,
            path: path.to_owned(),
        })
    }

    /// Bytes of the groups written so far.
    pub(crate) fn bytes(&self) -> usize {
        self.writer.bytes_written()
    }

    /// Adds rows, of the columns that the file was created with.
    pub(crate) fn add(&mut self, columns: &[Column]) -> Result<(), ExportError> {
        let added = add_group(&mut self.writer, columns);
        added.map_err(|error| ExportError::table(&self.path, error))
    }

    /// Ends the file; `about` is a key and a value in its footer.
    pub(crate) fn close(mut self, about: Option<(&str, String)>) -> Result<(), ExportError> {
        if let Some((key, value)) = about {
            let entry = KeyValue::new(key.to_owned(), value);
            self.writer.append_key_value_metadata(entry);
        }
        let closed = self.writer.close().map(|_| ());
        closed.map_err(|error| ExportError::table(&self.path, error))
    }
}

fn add_group(
    writer: &mut SerializedFileWriter<File>,
    columns: &[Column],
) -> Result<(), ParquetError> {
    let mut rows = writer.next_row_group()?;
    for column in columns {
        // A group has no column of its own: its leaves are written in the order of the schema.
        let parts: &[bool] = match column.values {
            Values::Pictures(_) => &[false, true],
            _ => &[false],
        };
        for is_path in parts {
            if let Some(mut part) = rows.next_column()? {
                column.write(part.untyped(), *is_path)?;
                part.close()?;
            }
        }
    }
    rows.close()?;
    Ok(())
}
