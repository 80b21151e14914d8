//! Connections: counted, and closed when they have nothing to say.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, Sleep, sleep_until};

/// Connections at a time; the next ones are told to come back.
const MAX_CONNECTIONS: usize = 96;
/// A connection that asks for nothing for this long is closed. Counts anew with
/// every answer, not with every byte of a question.
const PATIENCE: Duration = Duration::from_secs(5);
/// A pause after an accept that failed, such as for want of file numbers.
const AFTER_FAILURE: Duration = Duration::from_millis(100);
const BUSY: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\n\
    Content-Type: text/plain\r\nContent-Length: 21\r\n\r\ntoo many connections\n";
/// No end.
const NEVER: u64 = u64::MAX;

/// Takes connections in, as many as there may be.
pub(super) struct Door {
    listener: TcpListener,
    places: Arc<Semaphore>,
}

impl Door {
    pub(super) fn new(listener: TcpListener) -> Self {
        Self {
            listener,
            places: Arc::new(Semaphore::new(MAX_CONNECTIONS)),
        }
    }
}

impl Listener for Door {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Connection, SocketAddr) {
        loop {
            let Ok((stream, from)) = self.listener.accept().await else {
                tokio::time::sleep(AFTER_FAILURE).await;
                continue;
            };
            if let Ok(place) = self.places.clone().try_acquire_owned() {
                // Without it small messages wait for the other end's receipts.
                let _small_messages_wait = stream.set_nodelay(true).is_err();
                return (Connection::new(stream, place), from);
            }
            // Who does not even read that may guess it.
            let _told = stream.try_write(BUSY).is_ok();
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// Until when a connection may be silent; shared with what answers it.
#[derive(Clone, Debug)]
pub(super) struct Patience {
    began: Instant,
    until_ms: Arc<AtomicU64>,
}

impl Patience {
    fn new() -> Self {
        let patience = Self {
            began: Instant::now(),
            until_ms: Arc::new(AtomicU64::new(0)),
        };
        patience.renew();
        patience
    }

    /// Counts anew.
    pub(super) fn renew(&self) {
        let until = (self.began.elapsed() + PATIENCE).as_millis();
        let until = u64::try_from(until).unwrap_or(NEVER);
        // One that has no end keeps none.
        let later = |now: u64| (now != NEVER).then_some(until);
        let _unless_endless = self
            .until_ms
            .fetch_update(Ordering::AcqRel, Ordering::Acquire, later)
            .is_ok();
    }

    /// A websocket looks after itself.
    pub(super) fn never_ends(&self) {
        self.until_ms.store(NEVER, Ordering::Release);
    }

    /// The moment it is over.
    fn end(&self) -> Option<Instant> {
        match self.until_ms.load(Ordering::Acquire) {
            NEVER => None,
            until => Some(self.began + Duration::from_millis(until)),
        }
    }
}

/// One connection.
pub(super) struct Connection {
    stream: TcpStream,
    patience: Patience,
    timer: Pin<Box<Sleep>>,
    _place: OwnedSemaphorePermit,
}

impl Connection {
    fn new(stream: TcpStream, place: OwnedSemaphorePermit) -> Self {
        Self {
            stream,
            patience: Patience::new(),
            timer: Box::pin(sleep_until(Instant::now() + PATIENCE)),
            _place: place,
        }
    }

    /// Ready with an error when the patience is over.
    fn poll_patience(&mut self, cx: &mut Context<'_>) -> Poll<io::Error> {
        loop {
            ready!(self.timer.as_mut().poll(cx));
            match self.patience.end() {
                None => return Poll::Pending,
                Some(end) if end <= Instant::now() => {
                    return Poll::Ready(io::ErrorKind::TimedOut.into());
                }
                Some(end) => self.timer.as_mut().reset(end),
            }
        }
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if let Poll::Ready(result) = Pin::new(&mut self.stream).poll_read(cx, buffer) {
            return Poll::Ready(result);
        }
        self.poll_patience(cx).map(Err)
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        match Pin::new(&mut self.stream).poll_write(cx, bytes) {
            Poll::Ready(written) => {
                self.patience.renew();
                Poll::Ready(written)
            }
            Poll::Pending => self.poll_patience(cx).map(Err),
        }
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        match Pin::new(&mut self.stream).poll_write_vectored(cx, bytes) {
            Poll::Ready(written) => {
                self.patience.renew();
                Poll::Ready(written)
            }
            Poll::Pending => self.poll_patience(cx).map(Err),
        }
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}

impl Connected<IncomingStream<'_, Door>> for Patience {
    fn connect_info(stream: IncomingStream<'_, Door>) -> Self {
        stream.io().patience.clone()
    }
}
