//! The HTTP server of the page (docs/page-protocol.md).

mod edit;
pub mod files;
pub mod gate;
mod link;
mod plain;
mod routes;
mod serve;
mod site;
mod slots;
mod socket;

pub use serve::{Listening, Site, bind};
