//! `robocell load`: another scene in the place of the one that runs.

use std::time::{Duration, Instant};

use cell_run::spec::Speed;
use supervisor::control::{Request, ask};
use supervisor::failure::{Code, Failure};

use super::session::Session;
use crate::args::LoadArgs;
use crate::say;

/// An orderly stop and a start take a few seconds.
const PATIENCE: Duration = Duration::from_secs(30);

/// Asks the launcher, and waits until the other scene is there.
pub(crate) fn load(args: &LoadArgs) -> Result<(), Failure> {
    let session = Session::of(&args.cell.cell)?;
    let request = Request::Load {
        demo: args.demo.clone(),
        policy: args.scene.policy.clone(),
        seed: args.scene.seed,
        speed: match args.scene.speed {
            // Its factor is 0, which the parser of a speed refuses.
            Speed::Max => "max".to_owned(),
            speed => speed.factor().to_string(),
        },
    };
    let reply = ask(&session.dir.control(), &request)?;
    if !reply.ok {
        return Err(Failure::configuration(reply.message));
    }
    say::line(&reply.message);
    let since = Instant::now();
    while since.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(50));
        // A start makes the run file, then the bus, then the control socket: the file alone proves
        // nothing.
        let there = Session::of(&args.cell.cell).is_ok_and(|now| {
            now.spec.run != session.spec.run && now.dir.control().exists() && now.join().is_ok()
        });
        if there {
            say::line("Paused: `robocell resume` starts it.");
            return Ok(());
        }
    }
    Err(Failure {
        code: Code::GaveUp,
        message: "the other scene does not start; `robocell logs` says more".to_owned(),
    })
}
