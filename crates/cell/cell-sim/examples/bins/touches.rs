//! Contacts of the arm with objects that it must not touch.

use std::collections::BTreeMap;
use std::fmt;

use cell_model::Cell;
use cell_sim::OneProcess;
use physics_proc::arm::touches::{ArmContact, Touched};

/// A contact of one link with one thing.
#[derive(Clone, Debug)]
struct Touch {
    ticks: u64,
    first_tick: u64,
    deepest_m: f64,
}

/// Contacts of a run.
pub(crate) struct Touches {
    fixtures: Vec<String>,
    objects: Vec<String>,
    /// The object that the cup held last: its face may touch that.
    last_held: Option<usize>,
    /// By the object that must not be touched, and the link.
    seen: BTreeMap<(String, usize), Touch>,
}

impl Touches {
    /// None yet.
    pub(crate) fn new(cell: &Cell) -> Self {
        let solid = cell.fixtures.iter().filter(|fixture| fixture.solid);
        Self {
            fixtures: solid.map(|fixture| fixture.name.clone()).collect(),
            objects: cell.objects.iter().map(|o| o.name.clone()).collect(),
            last_held: None,
            seen: BTreeMap::new(),
        }
    }

    /// Whether the arm touched a fixture, or a bin in another way than with the face of its cup
    /// at the start and the end of a grip.
    pub(crate) fn any(&self) -> bool {
        !self.seen.is_empty()
    }

    /// Looks at the present state.
    pub(crate) fn look(&mut self, sim: &OneProcess, loud: bool) {
        let held = sim.state().arms()[0].gripper.held_object as usize;
        self.last_held = held.checked_sub(1).or(self.last_held);
        for contact in sim.plant().world().arm_contacts(0) {
            if let Some(name) = self.name(sim, &contact) {
                self.count(sim.state().header.tick, name, &contact, loud);
            }
        }
    }

    /// The object that the arm must not touch in this way.
    fn name(&self, sim: &OneProcess, contact: &ArmContact) -> Option<String> {
        let index = match contact.with {
            Touched::Fixture(index) => return self.fixtures.get(index).cloned(),
            Touched::Arm(index) => return Some(format!("arm {index}")),
            Touched::Object(index) => index,
        };
        let name = self.objects.get(index)?;
        // Parts fall on what they fall on.
        if !name.starts_with("bin") {
            return None;
        }
        let decision = sim.decision();
        let mut placed = decision.placed.iter().take(decision.placed_count as usize);
        let stands = placed.any(|place| *place as usize == index);
        // At the start and the end of a grip the cup touches a bin with its face.
        if contact.at_cup && (!stands || self.last_held == Some(index)) {
            return None;
        }
        let holds = sim.state().arms()[0].gripper.held_object as usize == index + 1;
        let what = match (stands, holds) {
            (true, _) => "placed",
            (false, true) => "held",
            (false, false) => "loose",
        };
        Some(format!("{what} {name}"))
    }

    fn count(&mut self, tick: u64, name: String, contact: &ArmContact, loud: bool) {
        let key = (name, contact.link);
        if loud && !self.seen.contains_key(&key) {
            let [x, y, z] = contact.point;
            println!(
                "{:9.3} [touch] link {} and {} at ({x:.3}, {y:.3}, {z:.3}), {:.2} mm deep",
                tick as f64 * 1.0e-3,
                contact.link,
                key.0,
                contact.depth * 1.0e3
            );
        }
        let touch = self.seen.entry(key).or_insert(Touch {
            ticks: 0,
            first_tick: tick,
            deepest_m: f64::NEG_INFINITY,
        });
        touch.ticks += 1;
        touch.deepest_m = touch.deepest_m.max(contact.depth);
    }
}

impl fmt::Display for Touches {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.seen.is_empty() {
            return out.write_str("arm touched nothing");
        }
        out.write_str("arm TOUCHED")?;
        for ((name, link), touch) in &self.seen {
            write!(
                out,
                " {name} by link {link} ({} ticks from {:.3} s, {:.2} mm deep);",
                touch.ticks,
                touch.first_tick as f64 * 1.0e-3,
                touch.deepest_m * 1.0e3
            )?;
        }
        Ok(())
    }
}
