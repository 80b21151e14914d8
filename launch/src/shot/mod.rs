//! `robocell shot`: a picture of the page, taken by a browser without a window.

pub(crate) mod browser;
mod cell;
mod film;

pub(crate) use film::film;

use std::time::{Duration, Instant};

use crate::cli::ShotArgs;
use crate::failure::{Code, Context, Failure};
use crate::page::Entry;
use crate::progress::Progress;
use crate::run::plan::new_file;
use crate::say;
use browser::Browser;
use cell::{Shown, Subject};

/// A browser without a GPU draws the first picture slowly.
const PATIENCE: Duration = Duration::from_secs(60);
/// Between two questions whether the page is settled.
const NAP: Duration = Duration::from_millis(20);

/// True when the page shows what it was asked for.
const SETTLED: &str = "window.robocell !== undefined && window.robocell.settled()";

/// Takes the picture.
pub(crate) fn shot(args: &ShotArgs) -> Result<(), Failure> {
    let out = new_file(&args.out)?;
    // A signal must not leave the memory of a cell and the profile of a browser behind.
    cell_rt::signal::install_stop_handler().cannot("listen to signals")?;
    let progress = Progress::new("starting the cell");
    let shown = Shown::of(&Subject {
        args: &args.shown,
        time: args.time,
        cell: &args.cell.cell,
    })?;
    progress.say("starting the browser");
    let (width, height) = args.size;
    // A browser without a GPU takes every core for seconds; the cell goes first. The
    // browser inherits this.
    cell_rt::priority::set_idle().ok();
    let mut browser = Browser::start(width, height)?;
    // A cell that was started for the picture is at that time already.
    let time = args.time.filter(|_| args.shown.demo.is_none());
    let fragment = args.view.iter().cloned();
    let fragment = fragment.chain(time.map(|time| format!("t={time}")));
    progress.say("loading the page");
    open_page(&mut browser, shown.entry(), fragment)?;
    let picture = browser.picture()?;
    std::fs::write(&out, picture).cannot(format!("write {}", out.display()))?;
    drop(progress);
    say::line(format_args!("{}: {width} x {height}", out.display()));
    Ok(())
}

/// Opens the page with `fragment` in its address, and waits until it shows that.
fn open_page(
    browser: &mut Browser,
    entry: &Entry,
    fragment: impl Iterator<Item = String>,
) -> Result<(), Failure> {
    browser.set_cookie(&entry.url, &entry.cookie_name, &entry.cookie)?;
    let mut fragment: Vec<String> = fragment.collect();
    // The first of a name counts.
    fragment.extend(["quality=0".to_owned(), "shot".to_owned()]);
    browser.open(&format!("{}#{}", entry.url, fragment.join("&")))?;
    wait_for(browser, SETTLED, "the page")
}

/// Waits until a JavaScript expression is true.
fn wait_for(browser: &mut Browser, expression: &str, what: &str) -> Result<(), Failure> {
    let since = Instant::now();
    while browser.evaluate(expression)? != serde_json::Value::Bool(true) {
        not_stopped()?;
        if since.elapsed() > PATIENCE {
            let title = browser
                .evaluate("document.title + ': ' + document.body.innerText.slice(0, 300)")?;
            return Err(Failure {
                code: Code::GaveUp,
                message: format!(
                    "{what} does not come up within {} s; the page says: {}",
                    PATIENCE.as_secs(),
                    title.as_str().unwrap_or_default()
                ),
            });
        }
        std::thread::sleep(NAP);
    }
    Ok(())
}

/// Ends everything when Ctrl-C was pressed.
fn not_stopped() -> Result<(), Failure> {
    if cell_rt::signal::stop_requested() {
        return Err(Failure::configuration("stopped: no picture was taken"));
    }
    Ok(())
}
