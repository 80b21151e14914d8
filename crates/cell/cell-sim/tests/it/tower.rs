//! A policy of the user's own for several objects, as in docs/task-in-rust.md.

use std::sync::Arc;

use cell_model::Data;
use cell_sim::{OneProcess, eval};
use ipc_types::decision::Outcome;
use robocell_skills::{Pick, Place, Places, Progress, Setup, Skill as _, Status, World};
use robocell_task::{Job, Kind, Observation, Output, Policies, Policy, boxed};
use serde::{Deserialize, Serialize};

/// Every object goes to the next free slot of one place.
struct Tidy {
    setup: Arc<Setup>,
    place: usize,
}

/// The skill that runs, its object, and how far it is.
#[derive(Default, Serialize, Deserialize)]
struct Memory {
    skill: Option<(Name, usize)>,
    progress: Progress,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
enum Name {
    Pick,
    Place,
}

impl Policy for Tidy {
    type Memory = Memory;

    fn decide(
        &self,
        memory: &mut Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let mut arm = World::new(&self.setup, observation, job, out, 0);
        let mut objects = 0..self.setup.objects.len();
        let next = objects.find(|object| arm.slot_of(*object, self.place, 0.02).is_none());
        let held = arm.held().map(|object| (Name::Place, object));
        // A skill that runs is not left for another before it has ended.
        memory.skill = memory
            .skill
            .or(held)
            .or(next.map(|object| (Name::Pick, object)));
        let progress = &mut memory.progress;
        let status = match memory.skill {
            Some((Name::Pick, object)) => Pick::new(object).step(progress, &mut arm),
            Some((Name::Place, object)) => Place::new(object, self.place).step(progress, &mut arm),
            None => Status::Success,
        };
        let done = memory.skill.is_none();
        if status != Status::Running {
            *memory = Memory::default();
        }
        arm.finish();
        arm.report(done);
    }
}

fn policies() -> Policies {
    let kind = Kind::<Places>::new("tidy").policy("tidy", |task, cell| {
        let setup = Arc::new(Setup::new(cell, &task.place));
        let place = setup.need_place(cell, "tower")?;
        Ok(boxed(Tidy { setup, place }))
    });
    Policies::new().with(kind)
}

/// The cell of the cube with a second cube and a tower instead of the mark.
fn cell_file() -> String {
    let cube = std::fs::read_to_string(Data::checkout_dir().join("cells/cube.toml")).unwrap();
    let (head, task) = cube.split_once("[task]").unwrap();
    assert!(task.contains("[task.place.mark]"));
    let policies = head.find("policies = ").unwrap();
    let rest = head.find("time_limit_s").unwrap();
    let object = head.find("[[object]]").unwrap();
    let fixture = head.find("# Not an obstacle").unwrap();
    let second = head[object..fixture]
        .replace("\"cube\"", "\"second\"")
        .replace("[0.50, -0.25, 0.025]", "[0.60, -0.05, 0.025]");
    format!(
        "{}policies = [\"tidy\"]\ndefault_policy = \"tidy\"\n{}{second}{}\n[task]\nkind = \"tidy\"\n\n\
         [task.place.tower]\nposition_m = [0.50, 0.25, 0.0]\n\
         pattern = {{ kind = \"stack\", layers = 2, layer_height_m = 0.05 }}\n",
        &head[..policies],
        &head[rest..fixture],
        &head[fixture..]
    )
}

#[test]
fn a_policy_made_of_pick_and_place_tidies_every_object() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("cells")).unwrap();
    std::fs::write(dir.path().join("cells/tidy.toml"), cell_file()).unwrap();
    let data = Data::dir(dir.path()).with_robots_of(&Data::checkout());
    let mut spec = eval::template("tidy", "tidy");
    spec.seed = 2;
    let cell = spec.load_cell_from(&data).unwrap();
    let mut sim = OneProcess::new(&policies(), &spec, cell).unwrap();
    let ended = |sim: &OneProcess| {
        let outcome = Outcome::from_code(sim.decision().outcome);
        matches!(outcome, Some(Outcome::Done | Outcome::Failed))
    };
    while !ended(&sim) && sim.state().header.tick < 60_000 {
        assert!(sim.tick().unwrap(), "the run ended");
    }
    let decision = sim.decision();
    assert_eq!(Outcome::from_code(decision.outcome), Some(Outcome::Done));
    assert_eq!((decision.placed_count, decision.drops), (2, 0));
    assert!(sim.state().objects()[1].pose.position[2] > 0.07, "on top");
}

#[test]
fn the_guide_quotes_the_policy() {
    let docs = std::fs::read_to_string(Data::checkout_dir().join("docs/task-in-rust.md")).unwrap();
    let own = include_str!("tower.rs");
    let policy = own.split("/// Every object goes to").nth(1).unwrap();
    let policy = policy.split("\nfn policies").next().unwrap().trim_end();
    assert!(
        docs.contains(policy),
        "docs/task-in-rust.md shows another policy"
    );
}
