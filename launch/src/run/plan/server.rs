//! The use of a policy behind a socket.

use std::path::{Path, PathBuf};

use cell_model::runs::policy_server::{PolicyServer, is_address, read_names};
use cell_run::spec::Speed;
use supervisor::failure::{Context as _, Failure};

use super::paths::absolute;
use crate::args::RunArgs;
use crate::args::server::ServerArgs;

/// The use of the policy server, if the policy is the address of one.
pub(super) fn server_of(args: &RunArgs, policy: &str) -> Result<Option<PolicyServer>, Failure> {
    let ServerArgs {
        names,
        keep_answers,
        answers,
    } = &args.server;
    let is_given = names.is_some() || keep_answers.is_some() || answers.is_some();
    if !is_address(policy) {
        let is_given = is_given || args.latency_ms.is_some() || args.fault.is_some();
        return not_for(policy, is_given).map(|()| None);
    }
    let real_time = args.scene.speed == Speed::RealTime && !args.one_process;
    if real_time && answers.is_some() {
        return Err(Failure::configuration(
            "--answers needs --speed max: in real time the steps in which answers come into force are \
             not those of the run that kept them",
        ));
    }
    let names = names.as_deref().map(read_names).transpose();
    let server = PolicyServer {
        latency_ms: args.latency_ms.unwrap_or_default(),
        names: names.map_err(Failure::configuration)?.unwrap_or_default(),
        keep: keep_answers.as_deref().map(absolute_dir).transpose()?,
        answers: answers.as_deref().map(absolute).transpose()?,
        fault: args.fault.clone(),
        real_time,
    };
    Ok(Some(
        server.of_episode(&format!("seed-{}", args.scene.seed)),
    ))
}

/// Refuses options of a policy server, if there are any, beside another policy.
pub(crate) fn not_for(policy: &str, is_given: bool) -> Result<(), Failure> {
    if !is_given {
        return Ok(());
    }
    Err(Failure::configuration(format!(
        "--latency-ms, --fault, --names, --keep-answers and --answers belong to a policy behind a socket, and \
         '{policy}' is none; --policy ws://HOST:PORT names one"
    )))
}

/// The path of a directory that may not exist yet.
fn absolute_dir(path: &Path) -> Result<PathBuf, Failure> {
    std::path::absolute(path).cannot(format!("find {}", path.display()))
}
