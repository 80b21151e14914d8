//! `robocell new`: a project of the user's own, in a folder of its own.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use cell_model::Data;
use supervisor::failure::{Context as _, Failure};

use crate::args::{NewArgs, Way};
use crate::say;

/// Packages a project depends on, and where they are in a checkout.
const PACKAGES: [(&str, &str); 5] = [
    ("robocell-behavior", "crates/core/behavior"),
    ("robocell-gateways", "crates/gateways/all"),
    ("robocell-skills", "crates/tasks/skills"),
    ("robocell-task", "crates/tasks/task"),
    ("robocell-task-program", "crates/cell/task-program"),
];

/// A file of a project: its path, its text, and whether it can be executed.
struct File {
    path: String,
    text: String,
    executable: bool,
}

/// Makes the folder of a project.
pub(crate) fn new(args: &NewArgs) -> Result<(), Failure> {
    check_name(&args.name)?;
    let folder = Path::new(&args.name);
    // Also a link to nothing.
    if folder.symlink_metadata().is_ok() {
        return Err(Failure::configuration(format!(
            "{} exists; choose another name, or move it away",
            args.name
        )));
    }
    let crates = args.way.is_rust().then(|| checkout(args)).transpose()?;
    for file in files(args, crates.as_deref()) {
        let path = folder.join(&file.path);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).cannot(format!("create {}", parent.display()))?;
        }
        fs::write(&path, &file.text).cannot(format!("write {}", path.display()))?;
        if file.executable {
            let mode = fs::Permissions::from_mode(0o755);
            fs::set_permissions(&path, mode)
                .cannot(format!("make {} executable", path.display()))?;
        }
    }
    if let Some(lock) = crates
        .map(|dir| dir.join("Cargo.lock"))
        .filter(|l| l.is_file())
    {
        // The versions the checkout was tested with, also without a network.
        fs::copy(&lock, folder.join("Cargo.lock")).cannot(format!("copy {}", lock.display()))?;
    }
    let name = &args.name;
    say::line(format_args!(
        "created {name}; start it:\n\n    cd {name}\n    robocell run {name} --data . --until-done\n"
    ));
    Ok(())
}

/// A name that is a folder, a cell and a package.
fn check_name(name: &str) -> Result<(), Failure> {
    let known = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_';
    let good = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(known)
        && name.len() <= 16
        && !["test", "core", "std", "alloc", "main"].contains(&name);
    if good {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "'{name}' cannot be the name of a project: a lower-case letter, then up to 15 lower-case \
         letters, digits, '-' and '_' are needed"
    )))
}

/// The folder with our packages.
fn checkout(args: &NewArgs) -> Result<PathBuf, Failure> {
    let (dir, asked) = match &args.crates {
        Some(dir) => (dir.clone(), true),
        None => (Data::checkout_dir(), false),
    };
    let here = PACKAGES
        .iter()
        .all(|(_, path)| dir.join(path).join("Cargo.toml").is_file());
    if here {
        // Absolute, as it is written to the `Cargo.toml` of another folder.
        return fs::canonicalize(&dir).cannot(format!("find {}", dir.display()));
    }
    Err(Failure::configuration(if asked {
        format!("{} is not a checkout of robocell", dir.display())
    } else {
        "the packages of robocell are not published yet, and the checkout this program was built \
         from is gone; name one with --crates DIR, or write the task as json, table or matrix, \
         which need no compiler"
            .to_owned()
    }))
}

fn files(args: &NewArgs, crates: Option<&Path>) -> Vec<File> {
    let fill = |template: &str| fill(template, args, crates);
    let name = &args.name;
    let file = |path: String, text: String| File {
        path,
        text,
        executable: false,
    };
    let mut files = vec![file(
        format!("cells/{name}.toml"),
        fill(include_str!("templates/cell.toml")),
    )];
    if !args.way.is_rust() {
        let path = format!("cells/{}", args.way.file(name));
        files.push(file(path, args.way.behaviour(name)));
        let readme = match args.way {
            Way::Python => include_str!("templates/README-python.md"),
            _ => include_str!("templates/README-file.md"),
        };
        files.push(file("README.md".to_owned(), fill(readme)));
        return files;
    }
    files.push(File {
        executable: true,
        ..file(
            format!("cells/{name}"),
            fill(include_str!("templates/program.sh")),
        )
    });
    for (path, template) in [
        ("README.md", include_str!("templates/README-rust.md")),
        ("Cargo.toml", include_str!("templates/Cargo.toml")),
        ("src/main.rs", include_str!("templates/main.rs")),
        ("src/lib.rs", include_str!("templates/lib.rs")),
        ("tests/job.rs", include_str!("templates/job.rs")),
    ] {
        files.push(file(path.to_owned(), fill(template)));
    }
    files.push(file("src/policy.rs".to_owned(), args.way.behaviour(name)));
    files.push(file(
        ".gitignore".to_owned(),
        "/target\n/.program\n".to_owned(),
    ));
    files
}

fn fill(template: &str, args: &NewArgs, crates: Option<&Path>) -> String {
    let (name, way) = (&args.name, args.way);
    let (policy, file) = (way.policy(name), way.file(name));
    let task = match way {
        Way::Python => format!("kind = \"{name}\"\nprogram = \"{file}\""),
        _ if way.is_rust() => format!("kind = \"{name}\"\nprogram = \"{name}\""),
        _ => format!("kind = \"{}\"\nbehaviour = \"{file}\"", way.kind()),
    };
    let patch = crates.map(|dir| {
        let line = |(package, path): &(&str, &str)| {
            let path = dir.join(path);
            format!("{package} = {{ path = {:?} }}", path.display().to_string())
        };
        let lines: Vec<String> = PACKAGES.iter().map(line).collect();
        format!(
            "\n# Until the packages are published: their checkout.\n[patch.crates-io]\n{}\n",
            lines.join("\n")
        )
    });
    let check = if way == Way::Json { "bt" } else { "fsm" };
    let filled = [
        ("{{description}}", "A Franka puts a cube on a mark"),
        ("{{name}}", name),
        ("{{crate}}", &name.replace('-', "_")),
        ("{{policy}}", policy),
        ("{{task}}", &task),
        ("{{file}}", &file),
        ("{{check}}", check),
        ("{{version}}", env!("CARGO_PKG_VERSION")),
        ("{{patch}}", patch.as_deref().unwrap_or_default()),
        ("{{imports}}", way.imports()),
        ("{{make}}", way.make()),
    ];
    filled
        .into_iter()
        .fold(template.to_owned(), |text, (key, value)| {
            text.replace(key, value)
        })
}

impl Way {
    fn is_rust(self) -> bool {
        matches!(self, Self::Ifelse | Self::Fsm | Self::Tree)
    }

    /// Name of the policy.
    fn policy(self, name: &str) -> &str {
        match self {
            Self::Ifelse => "ifelse",
            Self::Fsm => "fsm",
            Self::Tree => "tree",
            Self::Json => "json",
            Self::Table => "table",
            Self::Matrix => "matrix",
            Self::Python => name,
        }
    }

    /// The kind of `[task]` of a behaviour file.
    fn kind(self) -> &'static str {
        match self {
            Self::Table => "machine",
            Self::Matrix => "matrix",
            _ => "tree",
        }
    }

    /// Name of the behaviour file.
    fn file(self, name: &str) -> String {
        match self {
            Self::Json => format!("{name}.tree.json"),
            Self::Table => format!("{name}.machine.toml"),
            Self::Matrix => format!("{name}.matrix.toml"),
            Self::Python => format!("{name}.py"),
            Self::Ifelse | Self::Fsm | Self::Tree => "policy.rs".to_owned(),
        }
    }

    /// The job in this way; docs/choosing.md compares those that are not Python.
    fn behaviour(self, name: &str) -> String {
        let text = match self {
            Self::Ifelse => include_str!("../../../cells/cube/ifelse.rs"),
            Self::Fsm => include_str!("../../../cells/cube/fsm.rs"),
            Self::Tree => include_str!("../../../cells/cube/tree.rs"),
            Self::Json => include_str!("../../../cells/cube/cube.tree.json"),
            Self::Table => include_str!("../../../cells/cube/cube.machine.toml"),
            Self::Matrix => include_str!("../../../cells/cube/cube.matrix.toml"),
            Self::Python => include_str!("../../../cells/cube/cube.py"),
        };
        text.replacen("\"name\": \"cube\"", &format!("\"name\": \"{name}\""), 1)
            .replacen("\nname = \"cube\"", &format!("\nname = \"{name}\""), 1)
            .replacen("Tree::new(\"cube\"", &format!("Tree::new(\"{name}\""), 1)
    }

    fn imports(self) -> &'static str {
        match self {
            Self::Tree => ", SetupError",
            _ => ", boxed",
        }
    }

    /// How the registry makes the policy.
    fn make(self) -> &'static str {
        match self {
            Self::Ifelse => "Ok(boxed(policy::IfElse { setup, cube, mark }))",
            Self::Fsm => "Ok(boxed(policy::Fsm { setup, cube, mark }))",
            _ => {
                "let tree = policy::tree(cube, mark);\n        \
                 let tree = tree.map_err(|error| SetupError::new(cell, error.to_string()))?;\n        \
                 Ok(robocell_skills::files::tree_in_code(&setup, tree))"
            }
        }
    }
}
