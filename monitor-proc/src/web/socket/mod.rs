//! The websocket of one page: the newest frame and all messages to it, commands from it.
//!
//! A page may be slow, gone without a word, or hostile. The rules: every queue to and from a
//! page is bounded; a page that does not read gets the newest frame later instead of all
//! frames, and is closed when it reads nothing for ten seconds; no page can delay another one
//! or the monitor. Frames may be skipped, messages may not: a page that missed some is sent
//! the whole state.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::ws::{Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use futures_util::stream::SplitSink;
use futures_util::{SinkExt, StreamExt};
use serde_json::json;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::{MissedTickBehavior, interval, timeout};

use self::reader::Reader;
use super::state::AppState;
use crate::feed::broadcast::Subscription;
use crate::page::role::Role;
use crate::timeline::scrub::PastMoment;

mod reader;

/// Largest message of a page (bytes).
// Commands only; the library's default of 64 MiB would be reserved for one page.
const MAX_MESSAGE: usize = 64 << 10;
/// Largest number of bytes waiting to be written; a scene is the largest message.
const MAX_WAITING: usize = 1 << 20;
/// Answers waiting to be written.
// Beyond it commands wait, which slows down a page that floods.
const MAX_ANSWERS: usize = 64;
/// Interval at which a page is tested for presence; two missing answers are tolerated.
// Three unanswered in a row close the page: a browser in the background answers late.
const PING: Duration = Duration::from_secs(10);
/// A page that reads nothing for this time is closed.
const SEND_PATIENCE: Duration = Duration::from_secs(10);
/// Time for the closing message.
const CLOSING_TIME: Duration = Duration::from_secs(1);
/// Sent when a page that showed the past returns to the present.
const NOW: &str = r#"{"t":"now"}"#;

type Sink = SplitSink<WebSocket, Message>;

/// Messages from the reading half to the writing half.
enum Out {
    // One writer: two tasks writing to one socket would mix their messages.
    Text(Utf8Bytes),
    /// Send the task's state again.
    Again,
    /// Show these moments, or the present.
    Past(Option<watch::Receiver<PastMoment>>),
}

/// Sets the limits of a websocket.
pub(super) fn limit(upgrade: WebSocketUpgrade) -> WebSocketUpgrade {
    upgrade
        .max_message_size(MAX_MESSAGE)
        .max_frame_size(MAX_MESSAGE)
        .read_buffer_size(16 << 10)
        // Written at once: a frame that waits in a buffer is an old frame.
        .write_buffer_size(0)
        .max_write_buffer_size(MAX_WAITING)
}

/// Serves one page until it closes.
pub(super) async fn serve(socket: WebSocket, state: Arc<AppState>, role: Role) {
    // Before anything is read: the page is a subscriber from here on and misses no message.
    let subscription = state.services.broadcast.subscribe(role);
    let (sink, stream) = socket.split();
    let (out, outgoing) = mpsc::channel(MAX_ANSWERS);
    let (close, closed) = oneshot::channel();
    let is_alive = Arc::new(AtomicBool::new(true));
    let writer = Writer {
        sink,
        state: state.clone(),
        outgoing,
        past: None,
        is_alive: is_alive.clone(),
        missed_pings: 0,
    };
    let reader = Reader::new(state, role, out);
    // Either half ends the page: the writer when sending fails, the reader when the page ends.
    let mut writing = std::pin::pin!(writer.run(subscription, closed));
    tokio::select! {
        () = &mut writing => {}
        why = reader.run(stream, &is_alive) => {
            let is_sent = close.send(why).is_ok();
            if is_sent {
                // A page that does not read it is closed all the same.
                let _sent = timeout(CLOSING_TIME, writing).await.is_ok();
            }
        }
    }
}

struct Writer {
    sink: Sink,
    state: Arc<AppState>,
    outgoing: mpsc::Receiver<Out>,
    past: Option<watch::Receiver<PastMoment>>,
    is_alive: Arc<AtomicBool>,
    missed_pings: u32,
}

impl Writer {
    async fn run(
        mut self,
        mut updates: Subscription,
        mut closed: oneshot::Receiver<Option<&'static str>>,
    ) {
        // The whole state first, then changes to it.
        for text in std::mem::take(&mut updates.state) {
            if !self.text(text).await {
                return;
            }
        }
        let mut ping = interval(PING);
        // After a pause of the machine one ping, not a burst that no page can answer.
        ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let continues = tokio::select! {
                // In this order: an end comes first, with what waits; answers before messages, and frames last, as
                // only they may be skipped; at most one message is sent without the frame that
                // waits beside it.
                biased;
                why = &mut closed => return self.close(why.ok().flatten()).await,
                why = closed_for(&mut updates.close_reason) => {
                    let is_sent = self.rest(&mut updates).await;
                    return self.close(Some(why).filter(|_| is_sent)).await;
                }
                Some(out) = self.outgoing.recv() => self.out(out, &mut updates.frames).await,
                message = updates.messages.recv() => match message {
                    // A page that reads slowly has messages waiting at all times: without a
                    // frame between them its clock would be behind its log by seconds.
                    Ok(text) => self.text(text).await && self.waiting_frame(&mut updates.frames).await,
                    // The page was too slow for the messages: it gets the
                    // whole state instead of a gap.
                    Err(RecvError::Lagged(_)) => self.send_state().await,
                    Err(RecvError::Closed) => return self.close(Some("end")).await,
                },
                shown = newest(&mut updates.frames, &mut self.past) => self.show(shown).await,
                _ = ping.tick() => self.ping().await,
            };
            if !continues {
                return;
            }
        }
    }

    async fn out(&mut self, out: Out, live: &mut watch::Receiver<Bytes>) -> bool {
        match out {
            Out::Text(text) => self.text(text).await,
            Out::Again => self.send_state().await,
            Out::Past(Some(moments)) => {
                self.past = Some(moments);
                live.mark_changed();
                true
            }
            Out::Past(None) => {
                self.past = None;
                // The present counts as new after a return from the past.
                live.mark_changed();
                self.text(Utf8Bytes::from_static(NOW)).await && self.send_state().await
            }
        }
    }

    async fn send_state(&mut self) -> bool {
        for text in self.state.services.broadcast.trace() {
            if !self.text(text).await {
                return false;
            }
        }
        true
    }

    /// Sends what waits: the end of a cell is shown as it was.
    async fn rest(&mut self, updates: &mut Subscription) -> bool {
        while let Ok(text) = updates.messages.try_recv() {
            if !self.text(text).await {
                return false;
            }
        }
        self.waiting_frame(&mut updates.frames).await
    }

    /// Sends the newest frame of the present if the page has not got it.
    async fn waiting_frame(&mut self, live: &mut watch::Receiver<Bytes>) -> bool {
        if self.past.is_some() || !live.has_changed().unwrap_or(false) {
            return true;
        }
        let frame = live.borrow_and_update().clone();
        frame.is_empty() || self.send(Message::Binary(frame)).await
    }

    /// The message about a moment is sent before its frame.
    async fn show(&mut self, shown: PastMoment) -> bool {
        let is_sent = shown.message.is_empty() || self.text(shown.message).await;
        is_sent && (shown.frame.is_empty() || self.send(Message::Binary(shown.frame)).await)
    }

    async fn text(&mut self, text: Utf8Bytes) -> bool {
        self.send(Message::Text(text)).await
    }

    async fn ping(&mut self) -> bool {
        self.missed_pings += 1;
        // Any message of the page counts as an answer, so a busy page is never closed.
        if self.is_alive.swap(false, Ordering::AcqRel) {
            self.missed_pings = 0;
        }
        self.missed_pings < 3 && self.send(Message::Ping(Bytes::new())).await
    }

    /// Other messages wait meanwhile; when it is done the newest frame is sent.
    async fn send(&mut self, message: Message) -> bool {
        matches!(
            timeout(SEND_PATIENCE, self.sink.send(message)).await,
            Ok(Ok(()))
        )
    }

    async fn close(mut self, why: Option<&'static str>) {
        if let Some(what) = why {
            let word = json!({ "t": "gone", "what": what }).to_string();
            if !self.text(Utf8Bytes::from(word)).await {
                return;
            }
        }
        let _closed = self.sink.close().await.is_ok();
    }
}

/// The reason why all connections end, once they do.
async fn closed_for(reason: &mut watch::Receiver<Option<&'static str>>) -> &'static str {
    match reason.wait_for(Option::is_some).await {
        Ok(why) => why.unwrap_or("end"),
        Err(_) => "end",
    }
}

/// The next moment to show: of the time the page shows, once one is available.
async fn newest(
    live: &mut watch::Receiver<Bytes>,
    past: &mut Option<watch::Receiver<PastMoment>>,
) -> PastMoment {
    let now = |frame| PastMoment {
        frame,
        ..PastMoment::default()
    };
    let Some(past) = past else {
        return now(changed(live).await);
    };
    // Until the first frame of the past is there the present continues: no black page.
    if !past.borrow().frame.is_empty() {
        return changed(past).await;
    }
    tokio::select! {
        moment = changed(past) => moment,
        frame = changed(live) => now(frame),
    }
}

async fn changed<T: Clone>(shown: &mut watch::Receiver<T>) -> T {
    if shown.changed().await.is_err() {
        // The thread that sent frames has ended; the last frame stays.
        std::future::pending::<()>().await;
    }
    shown.borrow_and_update().clone()
}
