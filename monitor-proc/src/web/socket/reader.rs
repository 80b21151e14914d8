//! The reading half of a page's websocket: commands and requests for the past.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use futures_util::StreamExt;
use futures_util::stream::SplitStream;
use serde_json::{Value, json};
use tokio::sync::{Semaphore, mpsc, oneshot};
use tokio::time::Instant;

use super::Out;
use crate::page::command::{self, Command, Order, PlayOrder};
use crate::page::queue::{Answer, Reply};
use crate::page::rate::RateLimit;
use crate::page::role::Role;
use crate::timeline::scrub::{Scrubber, SeekTarget};
use crate::web::state::AppState;

/// Commands of one page that are under way at a time.
// More are refused: a person waits for the answer to one.
const MAX_UNDER_WAY: usize = 8;

/// Takes the commands of one page.
pub(super) struct Reader {
    state: Arc<AppState>,
    role: Role,
    out: mpsc::Sender<Out>,
    under_way: Arc<Semaphore>,
    scrubber: Option<Scrubber>,
    start: Instant,
}

impl Reader {
    pub(super) fn new(state: Arc<AppState>, role: Role, out: mpsc::Sender<Out>) -> Self {
        Self {
            state,
            role,
            out,
            under_way: Arc::new(Semaphore::new(MAX_UNDER_WAY)),
            scrubber: None,
            start: Instant::now(),
        }
    }

    /// Reads until the page closes or has to be closed; then returns the reason.
    pub(super) async fn run(
        mut self,
        mut stream: SplitStream<WebSocket>,
        is_alive: &AtomicBool,
    ) -> Option<&'static str> {
        let mut limit = RateLimit::new(0.0);
        while let Some(message) = stream.next().await {
            is_alive.store(true, Ordering::Release);
            // Counted before parsing, which is the costly part.
            if !limit.allows(self.start.elapsed().as_secs_f64()) {
                return Some("flood");
            }
            match message {
                Ok(Message::Text(text)) => self.command(text.as_str()).await,
                Ok(Message::Binary(_)) => self.refuse(0, "commands are text").await,
                Ok(Message::Ping(_) | Message::Pong(_)) => {}
                Err(error) if is_too_large(&error) => return Some("too large"),
                Ok(Message::Close(_)) | Err(_) => return None,
            }
        }
        None
    }

    async fn command(&mut self, text: &str) {
        let value: Value = match serde_json::from_str(text) {
            Ok(value) => value,
            Err(error) => return self.refuse(0, &format!("not JSON: {error}")).await,
        };
        // The number first, so that every refusal can name its command.
        let id = command::id(&value);
        match command::parse(&value, &self.state.services.names) {
            Err(why) => self.refuse(id, &why).await,
            Ok(Command::Again) => {
                self.hand_over(Out::Again).await;
                self.answer(id, &Reply::done()).await;
            }
            Ok(Command::Seek(order)) => self.seek(id, order).await,
            Ok(Command::Order(order, description)) => self.order(id, order, &description).await,
        }
    }

    async fn order(&mut self, id: u64, order: Order, description: &str) {
        // Checked here for orders of every kind: viewers only look.
        if self.role < Role::Operator {
            let why = "this page may only look; give it the operator's token";
            return self.refuse(id, why).await;
        }
        if let Some(answer) = self.promise(id).await {
            self.state.services.queue.push(order, description, answer);
        }
    }

    /// Another time: of a live cell for this page only, of a replay for all.
    async fn seek(&mut self, id: u64, order: PlayOrder) {
        let services = &self.state.services;
        if !services.incidents.is_live() {
            return self.order(id, Order::Play(order), "").await;
        }
        let open = services.past.clone();
        // Without a time: back to the present.
        let Some(time_s) = order.time_s else {
            self.scrubber = None;
            self.hand_over(Out::Past(None)).await;
            return self.answer(id, &Reply::done()).await;
        };
        // One thread per page that shows the past, started with its first request.
        if self.scrubber.is_none() {
            match Scrubber::start(open) {
                Ok(scrubber) => {
                    self.hand_over(Out::Past(Some(scrubber.moments()))).await;
                    self.scrubber = Some(scrubber);
                }
                Err(error) => return self.refuse(id, &error.to_string()).await,
            }
        }
        if let Some(answer) = self.promise(id).await
            && let Some(scrubber) = &self.scrubber
        {
            let epoch = order.epoch;
            scrubber.seek(SeekTarget { epoch, time_s }, answer);
        }
    }

    /// The receiver of an answer, sent when it arrives; none when too many are awaited.
    async fn promise(&self, id: u64) -> Option<Answer> {
        let Ok(permit) = self.under_way.clone().try_acquire_owned() else {
            self.refuse(id, "busy with the commands before; try again")
                .await;
            return None;
        };
        let (answer, reply) = oneshot::channel();
        let out = self.out.clone();
        tokio::spawn(async move {
            let reply = reply.await;
            // The permit is free before the answer is sent: a slow page must not keep it.
            drop(permit);
            let no_answer = || Reply::refused("no answer; the monitor may be ending");
            let text = acknowledge(id, &reply.unwrap_or_else(|_| no_answer()));
            let _page_is_there = out.send(Out::Text(text)).await.is_ok();
        });
        Some(answer)
    }

    async fn refuse(&self, id: u64, why: &str) {
        self.answer(id, &Reply::refused(why)).await;
    }

    async fn answer(&self, id: u64, reply: &Reply) {
        self.hand_over(Out::Text(acknowledge(id, reply))).await;
    }

    async fn hand_over(&self, out: Out) {
        let _page_is_there = self.out.send(out).await.is_ok();
    }
}

fn acknowledge(id: u64, reply: &Reply) -> Utf8Bytes {
    let (ok, tick, message) = (reply.ok, reply.tick, &reply.message);
    let text = json!({ "t": "ack", "id": id, "ok": ok, "tick": tick, "message": message });
    Utf8Bytes::from(text.to_string())
}

/// The library distinguishes its reasons by text only.
fn is_too_large(error: &axum::Error) -> bool {
    error.to_string().contains("too long") || error.to_string().contains("Space limit")
}
