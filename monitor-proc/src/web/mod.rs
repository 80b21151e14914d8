//! The HTTP server of the page (docs/page-protocol.md).

pub mod access;
mod connection;
mod connection_limit;
mod edit;
mod file_response;
pub mod files;
pub mod page_server;
mod plain;
mod routes;
mod serve;
mod socket;
mod state;

pub use serve::{Listening, Services, bind};
pub use state::{KeptIncidents, Search, SearchOf};
