//! What a client of the control socket asks for.

use ipc_types::topic::Process;

use super::end::End;
use super::faults::script::named;
use super::plan::{Plan, Scene, title};
use super::planning::Planning;
use super::policy::choose;
use crate::control::Request;
use crate::failure::Failure;

/// What a client asked for and gets.
pub(super) enum Wish {
    End(End),
    Restart(Vec<Process>),
}

/// Whether a client's wish can be fulfilled, and what to say about it; nothing yet where
/// another scene is planned for it. Another policy is written down where the next start of
/// the task reads it.
pub(super) fn consider(
    plan: &mut Plan,
    planning: &mut Planning,
    processes: &[Process],
    request: Request,
) -> Result<Option<(Wish, String)>, Failure> {
    match request {
        Request::Down => Ok(Some((Wish::End(End::Stopped(None)), "stopping".to_owned()))),
        Request::Load {
            demo,
            policy,
            seed,
            speed,
        } => {
            let speed = speed.parse().map_err(Failure::usage)?;
            let scene = Scene::Other {
                demo,
                policy,
                seed,
                speed,
            };
            planning.start(plan, scene).map(|()| None)
        }
        Request::Restart { process, policy } => {
            let which = named(processes, &process);
            if which.is_empty() {
                let message = format!("this cell has no process `{process}`");
                return Err(Failure::configuration(message));
            }
            if let Some(policy) = policy {
                take_over(plan, &process, &policy)?;
            }
            let message = format!("restarting {process}");
            Ok(Some((Wish::Restart(which), message)))
        }
    }
}

fn take_over(plan: &mut Plan, process: &str, policy: &str) -> Result<(), Failure> {
    if process != "task" {
        let message = "--policy is for `restart task` only";
        return Err(Failure::configuration(message));
    }
    choose_policy(plan, policy)
}

/// The next start of the task has this policy.
pub(super) fn choose_policy(plan: &mut Plan, policy: &str) -> Result<(), Failure> {
    plan.spec.policy = choose(Some(policy), &plan.policies, "", &plan.spec.demo)?;
    plan.spec
        .save(&plan.dir.spec())
        .map_err(Failure::configuration)
}

/// The answer to a client whose scene is planned.
pub(super) fn setting_up(next: &Plan) -> String {
    let mut message = format!("setting up {}", title(&next.spec));
    for warning in &next.spec.warnings {
        message.push_str("; warning: ");
        message.push_str(warning);
    }
    message
}
