//! Commands to a replay: those of its clock only.

use std::sync::mpsc;

use ipc_types::OperatorRequest;
use ipc_types::operator::OperatorAction;

use crate::page::command::{Order, PlayOrder};
use crate::page::queue::{Answer, CommandQueue, Reply, send};

/// Passes orders to the clock.
pub(super) struct ReplayCommandQueue(pub(super) mpsc::Sender<PlayOrder>);

impl CommandQueue for ReplayCommandQueue {
    fn push(&self, order: Order, _description: &str, answer: Answer) {
        let reply = match play_order(&order) {
            Some(order) if self.0.send(order).is_ok() => Reply::done(),
            Some(_) => Reply::refused("the replay is ending"),
            None => Reply::refused("this is a recording: it cannot be changed"),
        };
        send(answer, reply);
    }
}

fn play_order(order: &Order) -> Option<PlayOrder> {
    match order {
        Order::Play(order) => Some(*order),
        Order::Operate(request) => button(request),
        Order::Launch(_) | Order::Record(_) => None,
    }
}

/// The buttons of a simulation control the replay.
fn button(request: &OperatorRequest) -> Option<PlayOrder> {
    let nothing = PlayOrder::default();
    match OperatorAction::from_code(request.action)? {
        OperatorAction::Pause => Some(PlayOrder {
            play: Some(false),
            ..nothing
        }),
        OperatorAction::Resume => Some(PlayOrder {
            play: Some(true),
            ..nothing
        }),
        OperatorAction::Step => Some(PlayOrder {
            step: Some(u64::from(request.count)),
            ..nothing
        }),
        OperatorAction::Reset => Some(PlayOrder {
            // The reset of a replay is its start.
            time_s: Some(0.0),
            ..nothing
        }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::command::{Command, Names, parse};
    use serde_json::json;
    use tokio::sync::oneshot;

    #[test]
    fn the_clock_obeys_and_the_past_does_not() {
        let (orders, clock) = mpsc::channel();
        let queue = ReplayCommandQueue(orders);
        let names = Names {
            objects: vec!["red_cube".to_owned()],
            arms: 1,
        };
        let ask = |command: serde_json::Value| {
            let Ok(Command::Order(order, description)) = parse(&command, &names) else {
                panic!("{command}");
            };
            let (answer, mut reply) = oneshot::channel();
            queue.push(order, &description, answer);
            reply.try_recv().unwrap()
        };
        assert!(ask(json!({ "id": 1, "do": "pause" })).ok);
        assert_eq!(clock.recv().unwrap().play, Some(false));
        assert!(ask(json!({ "id": 1, "do": "step", "count": 10 })).ok);
        assert_eq!(clock.recv().unwrap().step, Some(10));
        for command in [
            json!({ "id": 1, "do": "drag", "object": "red_cube", "to": [0, 0, 0] }),
            json!({ "id": 1, "do": "task_start" }),
            json!({ "id": 1, "do": "restart", "process": "task" }),
            json!({ "id": 1, "do": "record", "what": "start" }),
        ] {
            assert!(ask(command).message.contains("recording"));
        }
        assert!(clock.try_recv().is_err());
    }
}
