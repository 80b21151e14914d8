//! Configurations of zenoh for the two sides.

use std::path::Path;

use serde_json::{Value, json};
use zenoh::Config;

use super::network;
use crate::args::Args;
use crate::transport::TransportError;

/// For viewers: the user's configuration, at the endpoints of the command line.
pub(super) fn of_viewers(args: &Args) -> Result<Config, TransportError> {
    let mut config = base(args)?;
    // A file of the user may name endpoints itself.
    let is_given = args.config.is_some() && args.listen.is_empty() && args.connect.is_empty();
    if !is_given {
        set(
            &mut config,
            "listen/endpoints",
            &json!(args.view_endpoints()),
        )?;
        set(&mut config, "connect/endpoints", &json!(args.connect))?;
    }
    Ok(config)
}

/// For clients with the token: the same at one endpoint that requires it.
pub(super) fn of_commanders(args: &Args, dictionary: &Path) -> Result<Config, TransportError> {
    let mut config = base(args)?;
    // No outgoing connections: a router would pass the commands of all its clients.
    let none: [&str; 0] = [];
    set(
        &mut config,
        "listen/endpoints",
        &json!([args.control_listen]),
    )?;
    set(&mut config, "connect/endpoints", &json!(none))?;
    let path = "transport/auth/usrpwd/dictionary_file";
    set(&mut config, path, &json!(dictionary))?;
    Ok(config)
}

fn base(args: &Args) -> Result<Config, TransportError> {
    let mut config = match &args.config {
        Some(path) => Config::from_file(path)
            .map_err(|error| network(format!("read {}", path.display()), &error))?,
        None => Config::default(),
    };
    // After the file: these settings are what keeps the two sessions apart.
    set(&mut config, "mode", &json!("peer"))?;
    // Neither session searches for others, nor announces one to the other.
    set(&mut config, "scouting/multicast/enabled", &json!(false))?;
    set(&mut config, "scouting/gossip/enabled", &json!(false))?;
    // An endpoint that cannot be opened is an error at once, not after a wait.
    set(&mut config, "listen/exit_on_failure", &json!(true))?;
    Ok(config)
}

fn set(config: &mut Config, key: &str, value: &Value) -> Result<(), TransportError> {
    let set = config.insert_json5(key, &value.to_string());
    set.map_err(|error| network(format!("set {key} of zenoh to {value}"), &error))
}
