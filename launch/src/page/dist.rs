//! The built page. In a checkout it is built once, and again when its sources
//! changed, if Node.js is there; elsewhere it is part of the monitor.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

use cell_rt::lock::Lock;
use supervisor::rundir::shared_locks;

use crate::progress::Progress;
use crate::{asked, say};

/// Names the directory of the page's sources, in place of that of the checkout.
const ENV_UI: &str = "ROBOCELL_UI_DIR";

/// What the page is made of, under `monitor-proc/ui`.
const SOURCES: [&str; 6] = [
    "src",
    "index.html",
    "package.json",
    "package-lock.json",
    "tsconfig.json",
    "vite.config.ts",
];
/// How long another launcher may take to build it.
const PATIENCE: Duration = Duration::from_secs(180);

/// Directory of the page in a checkout, built if need be, and what to tell a
/// person where it could not be.
pub(crate) fn built() -> (Option<PathBuf>, String) {
    let Some(ui) = checkout() else {
        return (None, String::new());
    };
    let dist = ui.join("dist");
    match build(&ui) {
        Ok(()) => (Some(dist), String::new()),
        // An older page is better than none.
        Err(why) if is_built(&ui) => (Some(dist), format!("{why} The page of before is served.")),
        Err(why) => (None, why),
    }
}

/// `monitor-proc/ui` of the checkout that holds our executable.
pub(crate) fn checkout() -> Option<PathBuf> {
    if let Some(ui) = std::env::var_os(ENV_UI).filter(|ui| !ui.is_empty()) {
        return Some(PathBuf::from(ui));
    }
    let own = std::env::current_exe().ok()?;
    let uis = own.ancestors().map(|dir| dir.join("monitor-proc/ui"));
    uis.into_iter().find(|ui| ui.join("package.json").is_file())
}

/// Whether there is a page, of whatever age.
pub(crate) fn is_built(ui: &Path) -> bool {
    ui.join("dist/index.html").is_file()
}

fn build(ui: &Path) -> Result<(), String> {
    if !is_stale(ui) {
        return Ok(());
    }
    let _lock = take_turn(ui)?;
    put_back(ui);
    // Another process may just have built it.
    if !is_stale(ui) {
        return Ok(());
    }
    if !knows("node") || !knows("npm") {
        return Err(
            "The page is not built, because Node.js is missing: install Node.js 20 or newer \
             with npm, and start the cell again."
                .to_owned(),
        );
    }
    // npm writes the second file at the end of an installation: one that was interrupted is
    // repeated.
    if newest(&ui.join("package-lock.json")) > newest(&ui.join("node_modules/.package-lock.json")) {
        say::line("page: fetching its packages (npm ci) ...");
        npm(ui, &["ci", "--no-audit", "--no-fund", "--loglevel=error"])?;
    }
    say::line("page: building it once (npm run build) ...");
    npm(
        ui,
        &[
            "run",
            "--silent",
            "build",
            "--",
            "--outDir",
            "dist.new",
            "--emptyOutDir",
        ],
    )?;
    put_in_place(ui).map_err(|error| format!("cannot put the built page in place: {error}."))
}

/// Puts `dist.new` in the place of `dist`, so that half a page is never served. The old page
/// is kept as `dist.old` until the new one is there.
fn put_in_place(ui: &Path) -> io::Result<()> {
    let (new, dist, old) = (ui.join("dist.new"), ui.join("dist"), ui.join("dist.old"));
    // Without a new page the old one must not be moved.
    fs::metadata(&new)?;
    if dist.exists() {
        fs::remove_dir_all(&old).ok();
        fs::rename(&dist, &old)?;
    }
    let renamed = fs::rename(&new, &dist);
    put_back(ui);
    renamed
}

/// Puts the old page back if there is no other: its replacement failed or was killed.
fn put_back(ui: &Path) {
    let (dist, old) = (ui.join("dist"), ui.join("dist.old"));
    if !dist.exists() {
        fs::rename(&old, &dist).ok();
    }
    fs::remove_dir_all(&old).ok();
}

/// Builds the page alone, however many cells start at once.
fn take_turn(ui: &Path) -> Result<Lock, String> {
    let locks =
        shared_locks().map_err(|failure| format!("The page cannot be built: {failure}."))?;
    let path = locks.join("page.lock");
    let since = std::time::Instant::now();
    loop {
        match Lock::try_new(&path) {
            Ok(Some(lock)) => return Ok(lock),
            Ok(None) if since.elapsed() < PATIENCE => {
                std::thread::sleep(Duration::from_millis(200));
            }
            Ok(None) => {
                return Err(format!(
                    "Another robocell has been building the page in {} for long.",
                    ui.display()
                ));
            }
            Err(error) => {
                return Err(format!(
                    "The page cannot be built: {}: {error}.",
                    path.display()
                ));
            }
        }
    }
}

fn is_stale(ui: &Path) -> bool {
    let sources = SOURCES.iter().map(|source| newest(&ui.join(source))).max();
    sources.flatten() > newest(&ui.join("dist/index.html"))
}

/// When the file, or the newest file below the directory, was written.
fn newest(path: &Path) -> Option<SystemTime> {
    let meta = fs::metadata(path).ok()?;
    if !meta.is_dir() {
        return meta.modified().ok();
    }
    let entries = fs::read_dir(path).ok()?.flatten();
    entries.filter_map(|entry| newest(&entry.path())).max()
}

fn knows(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version");
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let said = asked::ask(&mut command, program, "its version", asked::QUICK);
    said.is_ok_and(|said| said.status.success())
}

fn npm(ui: &Path, arguments: &[&str]) -> Result<(), String> {
    let _progress = Progress::new(format!("npm {}", arguments.join(" ")));
    let mut command = Command::new("npm");
    command.args(arguments).current_dir(ui);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let what = arguments.join(" ");
    let said = asked::ask(&mut command, "npm", &format!("`{what}`"), asked::BUILD);
    let said = said.map_err(|error| format!("The page is not built: {error}."))?;
    if said.status.success() {
        return Ok(());
    }
    let text = [said.stdout, said.stderr].concat();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    let last = lines[lines.len().saturating_sub(6)..].join("\n  ");
    Err(format!(
        "The page is not built: `npm {what}` failed:\n  {last}\n "
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_stale_when_a_source_is_newer() {
        let ui = std::env::temp_dir().join(format!("robocell-ui-{}", std::process::id()));
        fs::create_dir_all(ui.join("src/deep")).unwrap();
        fs::create_dir_all(ui.join("dist")).unwrap();
        let write = |name: &str, day: u64| {
            let file = fs::File::create(ui.join(name)).unwrap();
            let time = SystemTime::UNIX_EPOCH + Duration::from_secs(86_400 * day);
            file.set_modified(time).unwrap();
        };
        write("src/deep/main.ts", 1);
        assert!(is_stale(&ui), "never built");
        write("dist/index.html", 2);
        assert!(!is_stale(&ui));
        write("src/deep/main.ts", 3);
        assert!(is_stale(&ui));
        fs::remove_dir_all(ui).unwrap();
    }

    #[test]
    fn the_old_page_is_there_until_the_new_one_is() {
        let ui = std::env::temp_dir().join(format!("robocell-ui-old-{}", std::process::id()));
        fs::remove_dir_all(&ui).ok();
        let make = |dir: &str, text: &str| {
            fs::create_dir_all(ui.join(dir)).unwrap();
            fs::write(ui.join(dir).join("index.html"), text).unwrap();
        };
        let served = || fs::read_to_string(ui.join("dist/index.html")).unwrap_or_default();
        make("dist.new", "first");
        put_in_place(&ui).unwrap();
        assert_eq!(served(), "first");
        make("dist.new", "second");
        put_in_place(&ui).unwrap();
        assert_eq!(served(), "second");
        // No new page: the one of before stays.
        put_in_place(&ui).unwrap_err();
        assert_eq!(served(), "second");
        // Killed between the two renames.
        fs::rename(ui.join("dist"), ui.join("dist.old")).unwrap();
        put_back(&ui);
        assert_eq!(served(), "second");
        let left: Vec<_> = fs::read_dir(&ui).unwrap().collect();
        assert_eq!(left.len(), 1, "{left:?}");
        fs::remove_dir_all(ui).unwrap();
    }
}
