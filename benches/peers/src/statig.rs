//! The machines in statig: states and events are types, compiled in.

use std::hint::black_box;

use statig::blocking::{IntoStateMachine, IntoStateMachineExt, Outcome, State};

use robocell_benches::{Subject, machines};

/// Both machines.
pub(crate) fn subjects() -> Vec<Subject> {
    let mut ring = Ring.state_machine();
    let mut palletizing = Palletizer::default().state_machine();
    let bin = [Bin::Go, Bin::Picked, Bin::Flipped, Bin::Picked, Bin::Placed];
    let mut events = bin.into_iter().cycle();
    vec![
        Subject::new("statig, 8 phases: event", move |times| {
            for _ in 0..times {
                ring.handle(black_box(&Done));
                black_box(ring.state());
            }
        })
        .peer_of(machines::PHASES),
        Subject::new("statig, palletizing: event", move |times| {
            for event in events.by_ref().zip(0..times).map(|(event, _)| event) {
                palletizing.handle(black_box(&event));
                black_box(palletizing.state());
            }
        })
        .peer_of(machines::PALLETIZING),
    ]
}

struct Ring;

/// A phase is done.
struct Done;

enum Phase {
    PreGrasp,
    Approach,
    Grasp,
    Lift,
    Transport,
    Lower,
    Release,
    Retract,
}

impl IntoStateMachine for Ring {
    type Event<'e> = Done;
    type Context<'c> = ();
    type State = Phase;
    type Superstate<'s> = ();

    fn initial() -> Phase {
        Phase::PreGrasp
    }
}

impl State<Ring> for Phase {
    fn call_handler(&mut self, _: &mut Ring, _: &Done, (): &mut ()) -> Outcome<Self> {
        Outcome::Transition(match self {
            Self::PreGrasp => Self::Approach,
            Self::Approach => Self::Grasp,
            Self::Grasp => Self::Lift,
            Self::Lift => Self::Transport,
            Self::Transport => Self::Lower,
            Self::Lower => Self::Release,
            Self::Release => Self::Retract,
            Self::Retract => Self::PreGrasp,
        })
    }
}

/// Every other bin is upside down; the layer is never full.
#[derive(Default)]
struct Palletizer {
    flipped: bool,
}

impl Palletizer {
    fn needs_flip(&mut self) -> bool {
        self.flipped ^= true;
        self.flipped
    }
}

#[derive(Clone, Copy)]
enum Bin {
    Go,
    Picked,
    Flipped,
    Placed,
}

enum Work {
    Idle,
    Picking,
    Flipping,
    Placing,
}

impl IntoStateMachine for Palletizer {
    type Event<'e> = Bin;
    type Context<'c> = ();
    type State = Work;
    type Superstate<'s> = ();

    fn initial() -> Work {
        Work::Idle
    }
}

impl State<Palletizer> for Work {
    fn call_handler(&mut self, own: &mut Palletizer, event: &Bin, (): &mut ()) -> Outcome<Self> {
        match (self, event) {
            (Self::Idle, Bin::Go) | (Self::Flipping, Bin::Flipped) => {
                Outcome::Transition(Self::Picking)
            }
            (Self::Picking, Bin::Picked) if own.needs_flip() => Outcome::Transition(Self::Flipping),
            (Self::Picking, Bin::Picked) => Outcome::Transition(Self::Placing),
            (Self::Placing, Bin::Placed) => Outcome::Transition(Self::Idle),
            _ => Outcome::Super,
        }
    }
}
