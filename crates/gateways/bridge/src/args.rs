//! The command line.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Parser;

use crate::endpoints::Stream;

/// Default endpoint of viewers.
// Local only: another machine is a decision of the user.
pub const VIEW_ENDPOINT: &str = "tcp/127.0.0.1:7447";
/// Default endpoint of clients that may command.
// A port of its session: zenoh authenticates links, not messages (ADR 0024).
pub const CONTROL_ENDPOINT: &str = "tcp/127.0.0.1:7448";

/// Republish a running cell over zenoh, for ROS 2 (`rmw_zenoh`).
#[derive(Clone, Debug, Parser)]
#[command(name = "bridge-proc", version)]
pub struct Args {
    /// Name of the cell, as of `robocell run --cell`
    #[arg(long, value_name = "NAME", default_value = "cell")]
    pub cell: String,
    /// Endpoints that viewers connect to [default: tcp/127.0.0.1:7447]
    #[arg(long, value_name = "ENDPOINT")]
    pub listen: Vec<String>,
    /// Router or peer to connect to; without `--listen` nothing is listened to then
    #[arg(long, value_name = "ENDPOINT")]
    pub connect: Vec<String>,
    /// Accept commands from clients that know the token in this file (mode 600)
    #[arg(long, value_name = "TOKENFILE")]
    pub control: Option<PathBuf>,
    /// Endpoint that clients with the token connect to, as user `control`
    #[arg(long, value_name = "ENDPOINT", default_value = CONTROL_ENDPOINT, requires = "control")]
    pub control_listen: String,
    /// Configuration of zenoh (JSON5): TLS, authentication, access control
    #[arg(long, value_name = "FILE.json5")]
    pub config: Option<PathBuf>,
    /// Rate of a stream, 0 for none, as in `joint_states=200`; repeatable
    #[arg(long = "rate", value_name = "STREAM=HZ", value_parser = rate)]
    pub rates: Vec<(Stream, f64)>,
    /// ROS domain
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=232))]
    pub domain: u32,
    /// ROS namespace of all topics and services, `/line1` for example
    #[arg(long, value_name = "NS", default_value = "", value_parser = namespace)]
    pub namespace: String,
}

impl Args {
    /// Requested rates by stream (1/s).
    pub fn rates(&self) -> BTreeMap<Stream, f64> {
        let defaults = Stream::ALL.into_iter().map(|s| (s, s.default_rate()));
        // The defaults first: a rate of the command line replaces them.
        defaults.chain(self.rates.iter().copied()).collect()
    }

    /// Endpoints that viewers connect to.
    pub fn view_endpoints(&self) -> Vec<String> {
        // With `--connect` alone the user wants an outgoing connection only.
        if self.listen.is_empty() && self.connect.is_empty() {
            return vec![VIEW_ENDPOINT.to_owned()];
        }
        self.listen.clone()
    }
}

/// Possible rates (1/s); physics publishes 1000 states a second.
// The lower end keeps a period within a number of nanoseconds that cannot overflow.
const RATES: std::ops::RangeInclusive<f64> = 0.1..=1000.0;

fn rate(text: &str) -> Result<(Stream, f64), String> {
    let names = Stream::ALL.map(Stream::name).join(", ");
    let hint = || format!("`{text}` is not STREAM=HZ; streams are {names}");
    let (name, rate) = text.split_once('=').ok_or_else(hint)?;
    let stream = Stream::ALL.into_iter().find(|s| s.name() == name);
    let stream = stream.ok_or_else(hint)?;
    let rate: f64 = rate.parse().map_err(|_not_a_number| hint())?;
    if rate == 0.0 || RATES.contains(&rate) {
        return Ok((stream, rate));
    }
    let (least, most) = (RATES.start(), RATES.end());
    Err(format!(
        "{rate} 1/s is not possible; 0, or {least} to {most} 1/s"
    ))
}

/// Checks a namespace by the rules of ROS: `/` and words of letters, digits and `_`.
fn namespace(text: &str) -> Result<String, String> {
    let is_word = |word: &str| {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        word.chars().all(plain) && word.chars().next().is_some_and(|c| !c.is_ascii_digit())
    };
    // `/line1/` and `/line1` are the same for people.
    let trimmed = text.trim_end_matches('/');
    let words = trimmed
        .strip_prefix('/')
        .map(|rest| rest.split('/').all(is_word));
    if trimmed.is_empty() || words == Some(true) {
        return Ok(trimmed.to_owned());
    }
    Err(format!(
        "`{text}` is not a namespace of ROS; write /NAME, of letters, digits and _"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_names_a_stream_and_is_in_range() {
        assert_eq!(rate("tf=30"), Ok((Stream::Transforms, 30.0)));
        assert_eq!(rate("clock=0"), Ok((Stream::Clock, 0.0)));
        for wrong in ["tf", "tf=fast", "poses=3", "tf=NaN", "tf=-1", "tf=1e9"] {
            rate(wrong).unwrap_err();
        }
        assert!(rate("poses=3").unwrap_err().contains("joint_states"));
    }

    #[test]
    fn a_namespace_is_one_of_ros() {
        assert_eq!(namespace("/line1/left/"), Ok("/line1/left".to_owned()));
        assert_eq!(namespace(""), Ok(String::new()));
        for wrong in ["line1", "/1line", "/a b", "/a//b", "/**"] {
            namespace(wrong).unwrap_err();
        }
    }
}
