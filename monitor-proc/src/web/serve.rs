//! The server itself: its address and its limits.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::Semaphore;

use super::connection::LimitedListener;
use super::connection_limit::Idle;
use super::routes;
use super::state::AppState;
pub use super::state::Services;

/// Largest number of websockets.
// Each gets every frame, 60 a second.
pub(super) const MAX_SOCKETS: usize = 16;
/// Pages that read the recording at a time.
// Each unpacks chunks from the same disk.
const MAX_READERS: usize = 2;
/// Connections waiting to be accepted.
const BACKLOG: u32 = 1024;
/// A small buffer: frames that a slow reader has not taken are replaced by newer ones, not kept
/// here.
const SEND_BUFFER: u32 = 128 << 10;
/// A former monitor may still hold the port.
const BIND_PAUSE: Duration = Duration::from_millis(100);
// Five seconds together: a killed monitor has released the port long before.
const BIND_TRIES: usize = 50;

/// An open port that is not served yet.
pub struct Listening {
    listener: TcpListener,
    address: SocketAddr,
}

/// Opens `address`; tries for five seconds.
///
/// # Errors
///
/// When it is taken, or not an address of this machine.
pub async fn bind(address: SocketAddr) -> io::Result<Listening> {
    let mut tries = 1;
    loop {
        match open(address) {
            Ok(listening) => return Ok(listening),
            Err(error) if tries >= BIND_TRIES => return Err(error),
            Err(_) => tries += 1,
        }
        tokio::time::sleep(BIND_PAUSE).await;
    }
}

fn open(address: SocketAddr) -> io::Result<Listening> {
    let socket = match address {
        SocketAddr::V4(_) => TcpSocket::new_v4()?,
        SocketAddr::V6(_) => TcpSocket::new_v6()?,
    };
    // A port in TIME_WAIT of the former monitor is ours as well.
    socket.set_reuseaddr(true)?;
    // Accepted sockets inherit it.
    socket.set_send_buffer_size(SEND_BUFFER)?;
    socket.bind(address)?;
    let listener = socket.listen(BACKLOG)?;
    let address = listener.local_addr()?;
    Ok(Listening { listener, address })
}

impl Listening {
    /// Address and port.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Serves `services`; ends only when it is dropped.
    ///
    /// # Errors
    ///
    /// When the port is lost.
    pub async fn serve(self, services: Services) -> io::Result<()> {
        let state = Arc::new(AppState {
            services,
            sockets: Arc::new(Semaphore::new(MAX_SOCKETS)),
            readers: Semaphore::new(MAX_READERS),
            searches: Arc::new(Semaphore::new(1)),
            edits: Semaphore::new(1),
        });
        let router = routes::router(state);
        let service = router.into_make_service_with_connect_info::<Idle>();
        axum::serve(LimitedListener::new(self.listener), service).await
    }
}
