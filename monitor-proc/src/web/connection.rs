//! Connections: limited in number, and closed when silent.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, Sleep, sleep_until};

use super::connection_limit::{ConnectionLimit, Idle, Permit};

/// Pause after an accept that failed, e.g. for lack of file descriptors.
// Without it the loop would spin on the same error.
const AFTER_FAILURE: Duration = Duration::from_millis(100);
const BUSY: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\n\
    Content-Type: text/plain\r\nContent-Length: 21\r\n\r\ntoo many connections\n";

/// Accepts as many connections as there are permits.
pub(super) struct LimitedListener {
    listener: TcpListener,
    limit: ConnectionLimit,
}

impl LimitedListener {
    pub(super) fn new(listener: TcpListener) -> Self {
        Self {
            listener,
            limit: ConnectionLimit::default(),
        }
    }
}

impl Listener for LimitedListener {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Connection, SocketAddr) {
        loop {
            let Ok((stream, from)) = self.listener.accept().await else {
                tokio::time::sleep(AFTER_FAILURE).await;
                continue;
            };
            if let Some(permit) = self.limit.take(from.ip()) {
                // Without it small messages wait for acknowledgements of the peer.
                let _small_messages_wait = stream.set_nodelay(true).is_err();
                return (Connection::new(stream, permit), from);
            }
            send_busy(&stream);
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// A peer that does not read this gets no message.
fn send_busy(stream: &TcpStream) {
    // Not waited for: a peer that reads nothing must not hold up the next accept.
    let _sent = stream.try_write(BUSY).is_ok();
}

/// One connection.
pub(super) struct Connection {
    stream: TcpStream,
    timer: Pin<Box<Sleep>>,
    permit: Permit,
    has_answered: bool,
}

impl Connection {
    fn new(stream: TcpStream, permit: Permit) -> Self {
        let end = permit.idle.end().unwrap_or_else(Instant::now);
        Self {
            stream,
            timer: Box::pin(sleep_until(end)),
            permit,
            has_answered: false,
        }
    }

    /// Ready with an error when the connection has to be closed.
    fn poll_closed(&mut self, cx: &mut Context<'_>) -> Poll<io::Error> {
        if Pin::new(&mut self.permit.closed).poll(cx).is_ready() {
            // Only before the first answer: in the middle of one
            // it would be taken for its content.
            if !self.has_answered {
                send_busy(&self.stream);
            }
            return Poll::Ready(io::ErrorKind::ConnectionAborted.into());
        }
        // The timer is set again when it fires, not with every
        // request: that is one atomic store.
        loop {
            ready!(self.timer.as_mut().poll(cx));
            match self.permit.idle.end() {
                None => return Poll::Pending,
                Some(end) if end <= Instant::now() => {
                    return Poll::Ready(io::ErrorKind::TimedOut.into());
                }
                Some(end) => self.timer.as_mut().reset(end),
            }
        }
    }

    /// Restarts the timeout after bytes of an answer were taken; checks it if they have to
    /// wait.
    fn after_write(
        &mut self,
        written: Poll<io::Result<usize>>,
        cx: &mut Context<'_>,
    ) -> Poll<io::Result<usize>> {
        // The peer takes nothing: only now the timeout may close the connection.
        if written.is_pending() {
            return self.poll_closed(cx).map(Err);
        }
        self.has_answered = true;
        self.permit.idle.restart();
        written
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        // Data first: a request that has arrived is served even if its permit is withdrawn now.
        if let Poll::Ready(result) = Pin::new(&mut self.stream).poll_read(cx, buffer) {
            return Poll::Ready(result);
        }
        self.poll_closed(cx).map(Err)
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.after_write(written, cx)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(cx, bytes);
        self.after_write(written, cx)
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

impl Connected<IncomingStream<'_, LimitedListener>> for Idle {
    fn connect_info(stream: IncomingStream<'_, LimitedListener>) -> Self {
        stream.io().permit.idle.clone()
    }
}
