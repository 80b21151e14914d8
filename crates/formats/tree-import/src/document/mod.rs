//! The XML: elements with their places, of a file and the files it includes.

mod elements;

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use behavior::descriptor::Errors;
use behavior::descriptor::json::Location;
use behavior::suggest;

use crate::limits::{MAX_BYTES, MAX_ELEMENTS, MAX_FILES, MAX_NESTING};
use elements::{Converter, without_comments};

/// An element with its place.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub file: String,
    pub place: Location,
}

impl Element {
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(key, _)| key == name);
        found.map(|(_, value)| value.as_str())
    }

    /// The registered name of the node: `<Action ID="Say">` is `<Say>`.
    pub(crate) fn node_type(&self) -> &str {
        match self.tag.as_str() {
            "Action" | "Condition" | "Control" | "Decorator" => self.get("ID").unwrap_or(""),
            tag => tag,
        }
    }
}

/// A port in `<TreeNodesModel>`.
#[derive(Clone, Debug)]
pub(crate) struct PortModel {
    pub name: String,
    pub reads: bool,
    pub writes: bool,
    pub type_name: Option<String>,
    pub default: Option<String>,
}

/// A type of node in `<TreeNodesModel>`.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub kind: String,
    pub ports: Vec<PortModel>,
}

/// The content of all files.
#[derive(Debug, Default)]
pub(crate) struct Project {
    pub trees: Vec<(String, Element)>,
    pub models: BTreeMap<String, Model>,
    pub main: String,
    pub notes: Vec<String>,
}

/// Reads a file and the files it includes.
pub(crate) fn read(
    file: &str,
    text: &str,
    include: &dyn Fn(&str) -> Option<String>,
    tree: Option<&str>,
) -> Result<Project, Errors> {
    let mut reader = Reader {
        include,
        project: Project::default(),
        read: Vec::new(),
        bytes: 0,
        errors: Errors::default(),
    };
    // Included files may include it, by a path from its folder.
    let path = Path::new(file).file_name().unwrap_or_default();
    let main = reader.file(file, Path::new(path), text);
    reader.choose_main(file, main, tree);
    reader.errors.or(reader.project)
}

struct Reader<'a> {
    include: &'a dyn Fn(&str) -> Option<String>,
    project: Project,
    /// Paths of the files that were read, from the folder of the first one.
    read: Vec<PathBuf>,
    bytes: usize,
    errors: Errors,
}

/// The tree that a file names for execution.
struct Main {
    place: Location,
    asked: Option<String>,
    /// Names of the trees of this file and of those it includes.
    trees: Vec<String>,
}

impl Reader<'_> {
    /// `path` is from the folder of the first file.
    fn file(&mut self, name: &str, path: &Path, text: &str) -> Option<Main> {
        // Noted before it is read, so that included files that include each other are read
        // once.
        self.read.push(path.to_owned());
        // The sum of all files is limited, not each one.
        self.bytes += text.len();
        if self.bytes > MAX_BYTES {
            let message = format!("all files together have more than {MAX_BYTES} bytes");
            self.errors.push(name, Location::START, message);
            return None;
        }
        let root = self.parse(name, text)?;
        if root.tag != "root" {
            let message = format!(
                "<root> is needed here, this is <{}>; is this a tree of BehaviorTree.CPP?",
                root.tag
            );
            self.errors.push(name, root.place, message);
            return None;
        }
        // The meaning of some nodes differs between versions 3 and 4: read as the other version
        // a tree would run almost as before, which is worse than not at all (ADR 0027).
        match root.get("BTCPP_format") {
            Some("4") => {}
            Some(other) => {
                let message = format!(
                    "BTCPP_format is \"{other}\", \"4\" is read; the script `convert_v3_to_v4.py` of \
                     BehaviorTree.CPP converts version 3"
                );
                self.errors.push(name, root.place, message);
                return None;
            }
            None => self.project.notes.push(format!(
                "{name}: <root> has no BTCPP_format=\"4\"; it is read as version 4, in which \
                 Sequence and Fallback of version 3 are the same"
            )),
        }
        let mut trees = Vec::new();
        for child in &root.children {
            match child.tag.as_str() {
                "include" => self.included(path, child, &mut trees),
                "BehaviorTree" => self.tree(child, &mut trees),
                "TreeNodesModel" => child.children.iter().for_each(|model| self.model(model)),
                other => {
                    let known = ["include", "BehaviorTree", "TreeNodesModel"];
                    let advice = suggest::advice(other, &known);
                    let message = format!("<{other}> is not allowed in <root>; {advice}");
                    self.errors.push(&child.file, child.place, message);
                }
            }
        }
        Some(Main {
            place: root.place,
            asked: root.get("main_tree_to_execute").map(str::to_owned),
            trees,
        })
    }

    fn parse(&mut self, name: &str, text: &str) -> Option<Element> {
        let text = &without_comments(text);
        // The parser's own limit of elements is reached before its memory grows.
        let options = roxmltree::ParsingOptions {
            nodes_limit: MAX_ELEMENTS,
            ..roxmltree::ParsingOptions::default()
        };
        match roxmltree::Document::parse_with_options(text, options) {
            Ok(document) => {
                let mut converter = Converter::new(name, text);
                let root = converter.element(document.root_element(), 0);
                let Some(place) = converter.too_deep else {
                    return Some(root);
                };
                let message = format!("elements are nested deeper than {MAX_NESTING} levels");
                self.errors.push(name, place, message);
                None
            }
            Err(error) => {
                let at = error.pos();
                let place = Location {
                    line: at.row,
                    column: at.col,
                };
                let message = match error {
                    roxmltree::Error::NodesLimitReached => {
                        format!("the file has more than {MAX_ELEMENTS} elements and texts")
                    }
                    error => format!("this is not XML: {error}"),
                };
                self.errors.push(name, place, message);
                None
            }
        }
    }

    fn included(&mut self, from: &Path, element: &Element, trees: &mut Vec<String>) {
        let (file, place) = (&element.file, element.place);
        let Some(written) = element.get("path") else {
            let message = "<include> needs path=\"FILE.xml\"";
            return self.errors.push(file, place, message);
        };
        // No ROS installation is needed to import, so its packages cannot be found.
        if let Some(package) = element.get("ros_pkg") {
            let message = format!(
                "<include> from the ROS package '{package}': copy the file beside this one and \
                 write its path"
            );
            return self.errors.push(file, place, message);
        }
        // Paths are relative to the file that includes, as in BehaviorTree.CPP.
        let folder = from.parent().unwrap_or(Path::new(""));
        let path = plain(&folder.join(written));
        // A file that several others include is read once.
        if self.read.contains(&path) {
            return;
        }
        if self.read.len() >= MAX_FILES {
            let message = format!("more than {MAX_FILES} files are included; join some of them");
            return self.errors.push(file, place, message);
        }
        let name = path.display().to_string();
        let Some(text) = (self.include)(&name) else {
            let message = format!("the file '{name}' cannot be read");
            return self.errors.push(file, place, message);
        };
        if let Some(main) = self.file(&name, &path, &text) {
            trees.extend(main.trees);
        }
    }

    fn tree(&mut self, element: &Element, trees: &mut Vec<String>) {
        let (file, place) = (&element.file, element.place);
        let count = self.project.trees.len();
        let name = element
            .get("ID")
            .map_or_else(|| format!("BehaviorTree_{count}"), str::to_owned);
        if self.project.trees.iter().any(|(known, _)| *known == name) {
            let message = format!("the BehaviorTree '{name}' is defined twice; keep one of them");
            return self.errors.push(file, place, message);
        }
        match element.children.as_slice() {
            [root] => {
                trees.push(name.clone());
                self.project.trees.push((name, root.clone()));
            }
            children => {
                let found = children.len();
                let message = format!("<BehaviorTree> needs exactly one node, here are {found}");
                self.errors.push(file, place, message);
            }
        }
    }

    fn model(&mut self, element: &Element) {
        let Some(name) = element.get("ID") else {
            return;
        };
        let port = |port: &Element| {
            // Other elements, such as a description, are not ports.
            let (reads, writes) = match port.tag.as_str() {
                "input_port" => (true, false),
                "output_port" => (false, true),
                "inout_port" => (true, true),
                _ => return None,
            };
            Some(PortModel {
                name: port.get("name")?.to_owned(),
                reads,
                writes,
                type_name: port.get("type").map(str::to_owned),
                default: port.get("default").map(str::to_owned),
            })
        };
        let model = Model {
            kind: element.tag.clone(),
            ports: element.children.iter().filter_map(port).collect(),
        };
        self.project.models.insert(name.to_owned(), model);
    }

    fn choose_main(&mut self, file: &str, main: Option<Main>, tree: Option<&str>) {
        let Some(main) = main else { return };
        // Trees of included files can be chosen, too.
        let known: Vec<&str> = main.trees.iter().map(String::as_str).collect();
        let asked = tree.or(main.asked.as_deref());
        let chosen = match (asked, known.as_slice()) {
            (Some(asked), _) if known.contains(&asked) => Ok(asked.to_owned()),
            (Some(asked), _) => Err(format!(
                "unknown BehaviorTree '{asked}'; {}",
                suggest::advice(asked, &known)
            )),
            (None, [only]) => Ok((*only).to_owned()),
            (None, []) => Err("this file has no <BehaviorTree>".to_owned()),
            (None, several) => Err(format!(
                "the tree to execute is not named; `--tree NAME` names it, or main_tree_to_execute in \
                 <root>: {}",
                several.join(", ")
            )),
        };
        match chosen {
            Ok(chosen) => self.project.main = chosen,
            Err(message) => self.errors.push(file, main.place, message),
        }
    }
}

/// The path without `.` and `..`: `a/../b` is `b`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}
