//! The server itself: its address, its limits, what it serves.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::Semaphore;

use super::link::LimitedListener;
use super::routes;
use super::site::Served;
pub use super::site::Site;
use super::slots::Idle;

/// Websockets at a time.
pub(super) const MAX_SOCKETS: usize = 16;
/// Pages that read what was recorded at once.
const MAX_READERS: usize = 2;
/// Connections that wait to be accepted.
const BACKLOG: u32 = 1024;
/// A small buffer: what a slow reader has not taken is replaced by the newest,
/// and not kept for it here.
const SEND_BUFFER: u32 = 128 << 10;
/// A monitor before this one may not have let go of the port yet.
const BIND_PAUSE: Duration = Duration::from_millis(100);
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

    /// Serves `site`; ends only when it is dropped.
    ///
    /// # Errors
    ///
    /// When the port is lost.
    pub async fn serve(self, site: Site) -> io::Result<()> {
        let served = Arc::new(Served {
            site,
            sockets: Arc::new(Semaphore::new(MAX_SOCKETS)),
            readers: Semaphore::new(MAX_READERS),
            edits: Semaphore::new(1),
        });
        let router = routes::router(served);
        let service = router.into_make_service_with_connect_info::<Idle>();
        axum::serve(LimitedListener::new(self.listener), service).await
    }
}
