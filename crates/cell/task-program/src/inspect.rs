//! Pictures, checks and schemas of behaviours: those of a policy, and those in
//! files.

use std::collections::BTreeSet;
use std::path::Path;

use behavior::descriptor::{Include, Source};
use behavior::graph::GraphKind;
use behavior::{Finding, Graph, machine, matrix, views};
use cell_model::cells::replace::Replace;
use cell_model::cells::setting::Setting;
use cell_model::{Cell, Data, ModelError, user_file};
use cell_sim::Program;
use robocell_task::{TaskError, TreeError, TreeTools};

/// Why a behaviour cannot be shown, or is refused.
#[derive(Debug, thiserror::Error)]
pub enum InspectError {
    /// The cell file or a robot.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The policy.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// A tree in a file.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// All errors of a behaviour.
    #[error("{0}")]
    Behaviour(String),
}

/// The kind of behaviour in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A tree, JSON.
    Tree,
    /// A machine or a matrix, TOML or JSON.
    Machine,
}

/// Pictures of a demo's policy, with `set` in place of numbers of its cell file, or of a file;
/// and probable mistakes in the files of a demo.
///
/// # Errors
/// When the demo, the policy or the file does not exist or is not valid.
pub fn graphs(
    program: &Program,
    kind: Kind,
    what: &str,
    policy: Option<&str>,
    (data, set, replace): (&Data, &[Setting], Vec<Replace>),
) -> Result<(Vec<Graph>, Vec<String>), InspectError> {
    // A file is drawn without a cell: its leaves are placeholders, and no demo has to fit.
    if is_file(what) {
        let graph = graph_of_file(program, kind, Path::new(what))?;
        return Ok((vec![graph], Vec::new()));
    }
    let mut cell = Cell::load_with(data, what, 0, None, set)?;
    cell.replace = replace;
    let policy = policy.unwrap_or_else(|| program.policies.default_policy(&cell));
    let task = program.policies.task(&cell, policy)?;
    Ok((task.graphs().to_vec(), task.warnings().to_vec()))
}

/// Draws pictures in `format`: text, a matrix as a table of at most `width` characters,
/// mermaid or dot; or names their nodes, one a line.
pub fn draw(graphs: &[Graph], format: &str, width: usize) -> String {
    if format == "names" {
        let nodes = graphs.iter().flat_map(|graph| &graph.nodes);
        // Sorted and without duplicates: the completion of a command line lists them.
        let names: BTreeSet<&str> = nodes.map(|node| node.name.as_str()).collect();
        return names.into_iter().collect::<Vec<_>>().join("\n");
    }
    let one = |graph: &Graph| match format {
        "mermaid" => views::mermaid(graph, None),
        _ if graph.kind == GraphKind::Matrix => views::matrix(graph, None, width),
        _ => views::text(graph, None),
    };
    let drawn: Vec<String> = graphs.iter().map(one).collect();
    drawn.join("\n")
}

/// Probable mistakes in a file.
///
/// # Errors
/// All errors in it.
pub fn check(program: &Program, kind: Kind, file: &Path) -> Result<Vec<Finding>, InspectError> {
    if kind == Kind::Tree && is_cell(file) {
        return check_cell(program, file);
    }
    let text = read(kind, file)?;
    let name = file.display().to_string();
    match kind {
        Kind::Tree => {
            let include = includes(file);
            let source = source(&name, &text, &include);
            with_trees(program, |tools| tools.check(&program.data, &source))
        }
        Kind::Machine => {
            let include = includes(file);
            let source = source(&name, &text, &include);
            // A kind knows the states that its code implements, so its check finds more; the
            // check of the engine alone is for files of no kind.
            if let Some(checked) = program.policies.check_machine(&source) {
                return checked.map_err(|wrong| InspectError::Behaviour(wrong.to_string()));
            }
            match table(&name, &text)? {
                Table::Machine(table) => Ok(machine::check(&table)),
                Table::Matrix(table) => Ok(matrix::check(&table)),
            }
        }
    }
}

/// Whether a file is that of a cell: TOML with `[task]`, which a machine does not have.
fn is_cell(file: &Path) -> bool {
    let is_toml = file.extension().is_some_and(|e| e == "toml");
    is_toml
        && user_file::read_text(file)
            .is_ok_and(|text| text.lines().any(|line| line.trim() == "[task]"))
}

/// Probable mistakes in a cell of trees, also those that only the trees of all arms show.
fn check_cell(program: &Program, file: &Path) -> Result<Vec<Finding>, InspectError> {
    // A name alone has no folder.
    let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    let cells = absolute.parent().filter(|dir| dir.ends_with("cells"));
    let (Some(cells), Some(name)) = (cells, file.file_stem().and_then(|name| name.to_str())) else {
        return Err(InspectError::Behaviour(format!(
            "{}: a cell file has to be in a folder `cells`",
            file.display()
        )));
    };
    let data = Data::dir(cells.parent().unwrap_or(cells)).with_robots_of(&program.data);
    let (_, warnings) = graphs(program, Kind::Tree, name, None, (&data, &[], Vec::new()))?;
    let finding = |message| Finding {
        rule: "cell",
        place: name.to_owned(),
        message,
    };
    Ok(warnings.into_iter().map(finding).collect())
}

/// The JSON Schema of a kind of file: `tree`, `machine` or `cell`.
///
/// # Errors
/// For an unknown kind of file.
pub fn schema(program: &Program, what: &str) -> Result<serde_json::Value, InspectError> {
    match what {
        "tree" => program
            .policies
            .tree_schema(&program.data)?
            .ok_or_else(no_trees),
        "machine" => Ok(behavior::machine::schema()),
        "cell" => Ok(program.policies.cell_schema()),
        _ => Err(InspectError::Behaviour(format!(
            "unknown schema '{what}'; known are tree, machine and cell"
        ))),
    }
}

// By its extension, not by its existence: a missing file is then reported as such, and not
// as an unknown demo.
fn is_file(what: &str) -> bool {
    let extension = Path::new(what).extension();
    extension.is_some_and(|e| e == "json" || e == "toml")
}

fn graph_of_file(program: &Program, kind: Kind, file: &Path) -> Result<Graph, InspectError> {
    let text = read(kind, file)?;
    let name = file.display().to_string();
    if kind == Kind::Tree {
        let include = includes(file);
        let source = source(&name, &text, &include);
        return with_trees(program, |tools| tools.graph(&program.data, &source));
    }
    Ok(match table(&name, &text)? {
        Table::Machine(table) => table.describe(),
        Table::Matrix(table) => table.describe(),
    })
}

enum Table {
    Machine(Box<machine::Table>),
    Matrix(Box<matrix::Table>),
}

/// A file with a `precedence` list is a matrix.
fn table(file: &str, text: &str) -> Result<Table, InspectError> {
    let broken = |problems: machine::Problems| InspectError::Behaviour(problems.to_string());
    if has_precedence(file, text) {
        let definition = matrix::Definition::read(file, text).map_err(broken)?;
        return Ok(Table::Matrix(
            definition.compile_alone().map_err(broken)?.into(),
        ));
    }
    let definition = machine::Definition::read(file, text).map_err(broken)?;
    Ok(Table::Machine(
        definition.compile_alone().map_err(broken)?.into(),
    ))
}

fn has_precedence(file: &str, text: &str) -> bool {
    let key = "precedence";
    if Path::new(file).extension().is_some_and(|e| e == "json") {
        // A file that does not parse is read as a machine, whose reader reports the error.
        serde_json::from_str::<serde_json::Value>(text).is_ok_and(|v| v.get(key).is_some())
    } else {
        text.parse::<toml::Table>()
            .is_ok_and(|t| t.contains_key(key))
    }
}

/// The result of the first kind of trees that accepts the file. If none does, the
/// shortest list of errors: the other kinds do not know its node types.
fn with_trees<T>(
    program: &Program,
    ask: impl Fn(&TreeTools) -> Result<T, TreeError>,
) -> Result<T, InspectError> {
    let mut shortest: Option<TreeError> = None;
    for tools in program.policies.trees() {
        match ask(tools) {
            Ok(answer) => return Ok(answer),
            Err(error) => {
                let lines = |error: &TreeError| error.to_string().lines().count();
                if shortest.as_ref().is_none_or(|s| lines(&error) < lines(s)) {
                    shortest = Some(error);
                }
            }
        }
    }
    Err(shortest.map_or_else(no_trees, InspectError::Tree))
}

fn no_trees() -> InspectError {
    let problem = "this task program has no node types for trees in files";
    InspectError::Behaviour(problem.to_owned())
}

/// Text of a file that looks like one of that kind.
fn read(kind: Kind, file: &Path) -> Result<String, InspectError> {
    let name = file.display();
    let text = user_file::read_text(file).map_err(|error| {
        let advice = match error.kind() {
            std::io::ErrorKind::NotFound => "; name a file, or a demo to show",
            _ => "",
        };
        InspectError::Behaviour(format!("{name}: {error}{advice}"))
    })?;
    // The format line of a tree, in any place of the file: a tree that is passed to the reader
    // of machines would get an error about its first key, which helps no user.
    let is_tree = text.contains("\"behavior-tree/");
    let other = match kind {
        Kind::Machine if is_tree => "this is a behaviour tree; use `robocell bt`",
        Kind::Tree if file.extension().is_some_and(|e| e == "toml") => {
            "trees are written in JSON; for a machine or a matrix use `robocell fsm`"
        }
        _ => return Ok(text),
    };
    Err(InspectError::Behaviour(format!("{name}: {other}")))
}

fn source<'a>(file: &'a str, text: &'a str, include: &'a Include) -> Source<'a> {
    Source {
        file,
        text,
        include,
    }
}

/// Included files are in the folder of the file.
fn includes(file: &Path) -> impl Fn(&str) -> Result<String, String> {
    let folder = file.parent().map(Path::to_path_buf).unwrap_or_default();
    move |name| user_file::read_text(&folder.join(name)).map_err(|error| error.to_string())
}
