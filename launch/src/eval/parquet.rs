//! The Parquet file of `robocell eval merge`, where this program is built with it.

use std::path::Path;

use crate::failure::Failure;

#[cfg(feature = "parquet")]
pub(super) use evaluation::parquet_file::ParquetFile;

/// Creates the file at `path`.
#[cfg(feature = "parquet")]
pub(super) fn create(path: &Path) -> Result<ParquetFile, Failure> {
    ParquetFile::create(path).map_err(Failure::configuration)
}

/// Refuses to create a file, and says which build can.
#[cfg(not(feature = "parquet"))]
pub(super) fn create(_path: &Path) -> Result<ParquetFile, Failure> {
    Err(Failure::configuration(
        "--parquet: this robocell is built without the feature `parquet`; in its sources, \
         `cargo build --release -p robocell-launch --features parquet` builds \
         target/release/robocell with it",
    ))
}

/// A file that cannot be created.
#[cfg(not(feature = "parquet"))]
pub(super) enum ParquetFile {}

#[cfg(not(feature = "parquet"))]
impl ParquetFile {
    pub(super) fn append(
        &mut self,
        _row: evaluation::row::Row,
    ) -> Result<(), evaluation::EvaluationError> {
        match *self {}
    }

    pub(super) fn finish(self) -> Result<(), evaluation::EvaluationError> {
        match self {}
    }
}
