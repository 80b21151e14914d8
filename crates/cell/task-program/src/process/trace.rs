//! The lines of the task for people: its start, lost checkpoints, pictures and statuses.

use cell_rt::Clock;
use ipc_types::trace::{TraceEvent, TraceKind};
use ipc_types::{Header, TICK_NS, TraceLine};

use robocell_task::starts::Begun;
use robocell_task::{Restored, TraceLineText};

use super::TaskProcess;

/// Interval of the statuses of all nodes (ticks).
// Ten times a second: faster than people read, and 100 nodes are one line (ADR 0009).
const STATUS_TICKS: u64 = 100;
/// Shortest interval of the pictures (ticks).
// A page that connects late can draw within a second (ADR 0009). Pictures of more than 1000
// lines have a longer interval, of a tick for each line: a recording has all of them.
const PICTURE_TICKS: u64 = 1000;
/// Lines of the pictures sent at once, and the wall time between two such pieces (ns).
// The topic keeps 1024 lines, and the monitor reads them 60 times a second.
const PIECE_LINES: usize = 128;
const PIECE_NS: u64 = 5_000_000;

/// How far the pictures were sent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pictures {
    /// Tick at which they were begun last.
    drawn: Option<u64>,
    /// The next line that was not sent.
    next_line: Option<usize>,
    /// When a piece was sent last (ns).
    sent_ns: u64,
}

impl<C: Clock> TaskProcess<C> {
    pub(super) fn report(&mut self, begun: &Begun, restored: Restored, tick: u64) {
        match begun {
            Begun::Resumed if restored == Restored::All => {
                self.say(tick, "[task] resumed where physics resumed");
            }
            Begun::Resumed => self.say(tick, restored.line()),
            Begun::Lost(error) => {
                cell_worker::warn(format_args!("{error}"));
                self.say(tick, "[task] started without a checkpoint");
            }
            Begun::Continued | Begun::Reconciled | Begun::NewScene => {}
        }
    }

    /// Reports lost checkpoints in the health of the process, and in the trace on a change.
    pub(super) fn report_lost(&mut self, tick: u64) {
        let lost = self.slots.lost();
        if self.lost == lost {
            return;
        }
        self.lost = lost.to_owned();
        self.health.fault((!lost.is_empty()).then_some(lost));
        if !self.lost.is_empty() {
            let line = format!("[task] {}", self.lost);
            self.say(tick, &line);
        }
    }

    /// Adds all node statuses at 10 Hz, and the pictures, in pieces, for new subscribers.
    pub(super) fn draw(&mut self, tick: u64) {
        let now_ns = self.clock.now_ns();
        let interval = self.picture_interval();
        // A tick that is earlier than the last picture is a new scene.
        if self
            .pictures
            .drawn
            .is_none_or(|drawn| tick >= drawn + interval || tick < drawn)
        {
            self.pictures.drawn = Some(tick);
            self.pictures.next_line = Some(0);
            self.pictures.sent_ns = 0;
        }
        if let Some(from) = self.pictures.next_line
            && now_ns >= self.pictures.sent_ns + PIECE_NS
        {
            let next = from + PIECE_LINES;
            let task = &self.decider.task;
            task.trace_pictures(from..next, &mut self.lines);
            self.pictures.next_line = (next < task.picture_lines()).then_some(next);
            self.pictures.sent_ns = now_ns;
        }
        if tick.is_multiple_of(STATUS_TICKS) {
            self.decider.task.trace_statuses(&mut self.lines);
        }
    }

    /// Simulated time does not advance while the cell is paused; a subscriber that connects
    /// then needs the pictures, too.
    pub(super) fn draw_while_nothing_moves(&mut self, now_ns: u64) {
        let Some((_, tick)) = self.decider.decided() else {
            return;
        };
        // Wall time, the only one that advances; the same period as with simulated time.
        let wait_ns = match self.pictures.next_line {
            Some(_) => PIECE_NS,
            None => self.picture_interval() * TICK_NS,
        };
        if now_ns < self.pictures.sent_ns + wait_ns {
            return;
        }
        if self.pictures.next_line.is_none() {
            self.pictures.drawn = None;
        }
        self.lines.clear();
        self.draw(tick);
        self.send_lines(tick);
    }

    /// Interval of the pictures (ticks).
    fn picture_interval(&self) -> u64 {
        PICTURE_TICKS.max(self.decider.task.picture_lines() as u64)
    }

    pub(super) fn send_lines(&mut self, tick: u64) {
        // The list is taken out and put back: it keeps its memory for the next decision.
        let lines = std::mem::take(&mut self.lines);
        for line in &lines {
            self.send_line(tick, line);
        }
        self.lines = lines;
    }

    pub(super) fn say(&mut self, tick: u64, text: &str) {
        let line = TraceLineText {
            kind: TraceKind::Lifecycle,
            graph: 0,
            node: 0,
            from: 0,
            to: 0,
            event: TraceEvent::Restart,
            text: ipc_types::Text::new(text),
        };
        self.send_line(tick, &line);
    }

    fn send_line(&mut self, tick: u64, line: &TraceLineText) {
        let write = |message: &mut TraceLine| {
            message.header = Header::caused_by::<TraceLine>(tick);
            message.kind = line.kind.code();
            message.graph = u32::try_from(line.graph).unwrap_or(u32::MAX);
            message.node = u32::try_from(line.node).unwrap_or(u32::MAX);
            message.from = line.from;
            message.to = line.to;
            message.event = line.event.code();
            message.text = line.text;
        };
        // A line that was not sent leaves a gap in the sequence, which readers count.
        let _sent = self.trace.publish(write).is_ok();
    }
}
