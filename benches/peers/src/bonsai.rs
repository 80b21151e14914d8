//! The tree of 27 nodes in bonsai-bt. Its root can either remember, and then evaluates no
//! condition again while the job runs, or not, and then all sequences restart at each tick;
//! ours does neither.

use std::hint::black_box;

use bonsai_bt::{Action, ActionArgs, BT, Behavior, Event, Select, Sequence, Status};

use robocell_benches::{Subject, trees};

const TICKS_A_PHASE: u32 = 10;
/// Leaves that run, in the whole tree.
const RUNNING_LEAVES: usize = 18;

#[derive(Clone)]
enum Do {
    /// A condition that does not hold.
    Never,
    /// Runs for so many ticks; the first number is its place on the board.
    Run(usize, u32),
}

#[derive(Default)]
struct Board {
    ticks: [u32; RUNNING_LEAVES],
    calls: u64,
}

/// The two kinds of root.
pub(crate) fn subjects() -> Vec<Subject> {
    let subject = |name, memory| {
        let mut tree = BT::new(pick_and_place(memory), Board::default());
        Subject::new(name, move |times| run(&mut tree, times))
    };
    vec![
        subject("bonsai-bt, memory root: tick", true).peer_of(trees::TICK),
        subject("bonsai-bt, reactive root: tick", false),
    ]
}

fn run(tree: &mut BT<Do, Board>, times: u64) {
    for _ in 0..times {
        let answer = tree.tick(&Event::zero_dt_args(), &mut act);
        if black_box(answer).is_none_or(|(status, _)| status != Status::Running) {
            tree.reset_bt();
        }
    }
    black_box(tree.blackboard().calls);
}

#[allow(clippy::needless_pass_by_value, reason = "the library calls it so")]
fn act(args: ActionArgs<Event, Do>, board: &mut Board) -> (Status, f64) {
    board.calls += 1;
    let status = match args.action {
        Do::Never => Status::Failure,
        Do::Run(place, length) => match board.ticks.get_mut(*place) {
            Some(ticks) if *ticks + 1 < *length => {
                *ticks += 1;
                Status::Running
            }
            Some(ticks) => {
                *ticks = 0;
                Status::Success
            }
            None => Status::Failure,
        },
    };
    (status, args.dt)
}

fn pick_and_place(memory: bool) -> Behavior<Do> {
    let mut places = 0..RUNNING_LEAVES;
    let mut next = |length| Action(Do::Run(places.next().unwrap_or(usize::MAX), length));
    let never = || Action(Do::Never);
    let dropped = Sequence(vec![never(), next(1)]);
    let mut broken = vec![never()];
    broken.extend((0..5).map(|_| next(TICKS_A_PHASE)));
    broken.push(next(1));
    let select = next(1);
    let pickup = Sequence((0..2).map(|_| next(TICKS_A_PHASE)).collect());
    let (grasp, holding) = (next(TICKS_A_PHASE), next(1));
    let mut place: Vec<_> = (0..5).map(|_| next(TICKS_A_PHASE)).collect();
    place.push(next(1));
    let normal = Sequence(vec![select, pickup, grasp, holding, Sequence(place)]);
    let branches = vec![never(), dropped, Sequence(broken), normal];
    Select(branches).memory(memory)
}
