//! `robocell top`: a running cell in the terminal.

mod draw;
mod earlier;
pub(super) mod equipment;
mod screen;

use std::io::IsTerminal;
use std::time::Duration;

use cell_bus::Subscriber;
use crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use ipc_types::TraceLine;
use ipc_types::topic::TopicId;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::{Context, Failure};

use self::screen::Screen;
use super::columns::terminal_width;
use super::picture::Picture;
use super::session::Session;
use super::status::{Status, describe};
use super::watched::Trace;
use crate::args::TopArgs;
use crate::{output, say};

/// How often a frame is drawn.
const FRAME: Duration = Duration::from_millis(100);
/// The task sends its pictures once a second; one that is gone sends none.
const FRAMES_FOR_PICTURES: usize = 13;
/// Size of the frame printed in a pipe (characters).
const ONCE: (u16, u16) = (130, 30);

/// Lines that can be in the log and still on their way.
const OVERLAP: usize = 20;
/// The log gives milliseconds.
const HALF_A_TICK_S: f64 = 0.5e-3;

/// The data of a frame.
pub(crate) struct View {
    pub(crate) session: Session,
    pub(crate) picture: Picture,
    lines: Subscriber<TraceLine>,
    /// Lines that were overwritten before they were read.
    missed: u64,
    pub(crate) trace: Trace,
    /// Names of what a state only numbers.
    names: equipment::Names,
}

impl View {
    /// Joins the running cell of that name.
    pub(crate) fn open(cell: &str) -> Result<Self, Failure> {
        let session = Session::of(cell)?;
        let bus = session.join()?;
        let lines = bus
            .subscriber(TopicId::Trace)
            .cannot("read the task's log")?;
        let picture = Picture::open(&session)?;
        let mut trace = Trace::default();
        // After the subscription: a line written in between is read twice, which `was_read` finds.
        // In the other order it would be lost.
        trace.log.extend(earlier::lines(&session.dir));
        // The run was started from the same files; changed since, they cost names.
        let cell = session.spec.load_cell().ok();
        Ok(Self {
            names: cell.as_ref().map(equipment::Names::of).unwrap_or_default(),
            session,
            picture,
            lines,
            missed: 0,
            trace,
        })
    }

    /// Takes new messages.
    pub(crate) fn update(&mut self) {
        self.picture.update();
        let trace = &mut self.trace;
        self.lines.take_all(|line| {
            if !was_read(trace, line) {
                trace.take(line);
            }
        });
        let late = self.lines.counts().late;
        if late > self.missed {
            let time_s = trace.log.back().map_or(0.0, |(at_s, _)| *at_s);
            trace.missed(time_s, late - self.missed);
        }
        self.missed = late;
    }
}

/// Whether a line is among the last ones already: what was said while the log
/// was being read comes twice.
fn was_read(trace: &Trace, line: &TraceLine) -> bool {
    let time_s = line.header.sim_time_ns as f64 * 1.0e-9;
    let mut newest = trace.log.iter().rev().take(OVERLAP);
    newest.any(|(at, said)| (at - time_s).abs() < HALF_A_TICK_S && said == line.text.as_str())
}

/// The result of `robocell top --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Snapshot {
    #[serde(flatten)]
    status: Status,
    /// The nodes or states at work, by picture of the policy.
    active: Vec<String>,
    /// The last lines of the task, the oldest first.
    log: Vec<TaskLine>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct TaskLine {
    sim_time_s: f64,
    text: String,
}

impl Snapshot {
    fn of(view: &View) -> Result<Self, Failure> {
        let cell = view.session.load_cell()?;
        let lines = view.trace.log.iter().map(|(at, text)| TaskLine {
            sim_time_s: *at,
            text: text.clone(),
        });
        Ok(Self {
            status: describe(&view.session, &view.picture, &cell),
            active: view.trace.active(),
            log: lines.collect(),
        })
    }
}

/// Shows the cell until `q`, or prints one frame.
pub(crate) fn top(args: &TopArgs) -> Result<(), Failure> {
    let is_pipe = !std::io::stdout().is_terminal();
    let mut view = View::open(&args.cell.cell)?;
    view.picture.fill();
    if is_pipe || args.json {
        for _ in 0..FRAMES_FOR_PICTURES {
            view.update();
            if view.trace.is_complete() {
                break;
            }
            std::thread::sleep(FRAME);
        }
        view.picture.fill();
        if args.json {
            return output::print(&Snapshot::of(&view)?);
        }
        return once(&Screen::of(&view));
    }
    watch(&mut view)
}

/// Draws the cell until it has ended or `q` is pressed.
fn watch(view: &mut View) -> Result<(), Failure> {
    let mut terminal = ratatui::try_init().map_err(|error| {
        // `try_init` enables raw mode first: it may be on although a later step failed.
        ratatui::restore();
        Failure::usage(format!(
            "this is not a terminal ({error}); `robocell top | cat` prints one frame as text"
        ))
    })?;
    let result = watch_in(&mut terminal, view);
    ratatui::restore();
    result
}

fn watch_in(terminal: &mut ratatui::DefaultTerminal, view: &mut View) -> Result<(), Failure> {
    loop {
        view.update();
        if view.session.dir.holder().is_none() {
            return Ok(());
        }
        let screen = Screen::of(view);
        terminal
            .draw(|frame| draw::draw(frame, &screen))
            .cannot("draw")?;
        if event::poll(FRAME).cannot("read the keyboard")?
            && let Event::Key(key) = event::read().cannot("read the keyboard")?
            && key.kind == KeyEventKind::Press
        {
            // In raw mode Ctrl-C is a key and sends no signal.
            let is_ctrl_c =
                key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
            if is_ctrl_c || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc) {
                return Ok(());
            }
        }
    }
}

/// One frame as plain text.
fn once(screen: &Screen) -> Result<(), Failure> {
    let width = terminal_width().min(usize::from(ONCE.0));
    let width = u16::try_from(width).unwrap_or(ONCE.0);
    let mut terminal = Terminal::new(TestBackend::new(width, ONCE.1)).cannot("draw")?;
    terminal
        .draw(|frame| draw::draw(frame, screen))
        .cannot("draw")?;
    let buffer = terminal.backend().buffer();
    for y in 0..buffer.area.height {
        let line: String = (0..buffer.area.width)
            .filter_map(|x| buffer.cell((x, y)))
            .map(ratatui::buffer::Cell::symbol)
            .collect();
        say::line(line.trim_end());
    }
    Ok(())
}
