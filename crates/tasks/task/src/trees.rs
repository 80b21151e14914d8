//! Checks, pictures and schemas of a tree in a file, without running it.

use std::collections::BTreeMap;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::{Host, Library};
use behavior::{Finding, Graph};
use cell_model::Data;
use serde_json::Value;

use crate::error::TaskError;

/// Why a tree in a file is refused.
#[derive(Debug, thiserror::Error)]
pub enum TreeError {
    /// The node types cannot be loaded.
    #[error(transparent)]
    Library(#[from] TaskError),
    /// All errors of the file, with file, line and column.
    #[error("{0}")]
    File(String),
}

type Checking = Box<dyn Fn(&Data, &Source<'_>) -> Result<Vec<Finding>, TreeError> + Send + Sync>;
type Drawing = Box<dyn Fn(&Data, &Source<'_>) -> Result<Graph, TreeError> + Send + Sync>;
type Describing = Box<dyn Fn(&Data) -> Result<Value, TreeError> + Send + Sync>;

/// Reads trees with the node types of one kind of `[task]`.
pub struct TreeTools {
    check: Checking,
    graph: Drawing,
    schema: Describing,
}

impl TreeTools {
    pub(crate) fn new<H: Host + 'static>(
        library: impl Fn(&Data) -> Result<Library<H>, TaskError> + Send + Sync + 'static,
    ) -> Self {
        let library = std::sync::Arc::new(library);
        let (for_check, for_graph, for_schema) = (library.clone(), library.clone(), library);
        Self {
            check: Box::new(move |data, source| {
                // Placeholders replace leaves that need a cell: the file is checked without
                // one, and no check runs a leaf.
                let known = for_check(data)?.with_placeholders();
                descriptor::check(source, &known, &BTreeMap::new(), &Board::new())
                    .map_err(|errors| TreeError::File(errors.to_string()))
            }),
            graph: Box::new(move |data, source| {
                let known = for_graph(data)?.with_placeholders();
                let tree = descriptor::load(source, &known, &BTreeMap::new(), &mut Board::new())
                    .map_err(|errors| TreeError::File(errors.to_string()))?;
                Ok(tree.graph())
            }),
            schema: Box::new(move |data| Ok(descriptor::schema(&for_schema(data)?))),
        }
    }

    /// Probable mistakes in a tree.
    ///
    /// # Errors
    /// Everything that is wrong in it.
    pub fn check(&self, data: &Data, source: &Source<'_>) -> Result<Vec<Finding>, TreeError> {
        (self.check)(data, source)
    }

    /// Its picture.
    ///
    /// # Errors
    /// Everything that is wrong in it.
    pub fn graph(&self, data: &Data, source: &Source<'_>) -> Result<Graph, TreeError> {
        (self.graph)(data, source)
    }

    /// The JSON Schema of such a file.
    ///
    /// # Errors
    /// When the node types cannot be loaded.
    pub fn schema(&self, data: &Data) -> Result<Value, TreeError> {
        (self.schema)(data)
    }
}

/// Adds the node types of one schema of trees to another.
pub(crate) fn merge_schema(all: &mut Value, more: &Value) {
    for definition in ["node", "guard"] {
        // The lists under these paths enumerate node types; all else is equal for all kinds.
        for list in ["/allOf", "/properties/type/enum", "/properties/type/anyOf"] {
            let path = format!("/$defs/{definition}{list}");
            let added = more.pointer(&path).and_then(Value::as_array);
            let known = all.pointer_mut(&path).and_then(Value::as_array_mut);
            if let (Some(known), Some(added)) = (known, added) {
                let new: Vec<Value> = added
                    .iter()
                    // A type that two kinds share is listed once: duplicates in an enum are not
                    // valid.
                    .filter(|item| !known.contains(item))
                    .cloned()
                    .collect();
                known.extend(new);
            }
        }
    }
}
