//! Kinds of `[task]` and the policies of a program.

use cell_model::{Cell, Data};
use robocell_task::{
    Job, Kind, NoSettings, Observation, Output, Policies, Policy, Settings, TaskError, boxed,
};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::bench::load;

struct Idle;

impl Policy for Idle {
    type Memory = ();

    fn decide(&self, (): &mut (), _: &Observation<'_>, _: &mut Job, _: &mut Output) {}
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Polish {
    #[schemars(range(min = 1, max = 9))]
    strokes: u32,
}

impl Settings for Polish {}

fn polish(policies: &[&'static str]) -> Kind<Polish> {
    policies.iter().fold(Kind::new("polish"), |kind, name| {
        kind.policy(name, |settings: &Polish, _| {
            assert!((1..=9).contains(&settings.strokes), "checked before");
            Ok(boxed(Idle))
        })
    })
}

/// The cell `reach` with that `[task]`.
fn cell(task: &str) -> Cell {
    let data = Data::checkout();
    let text = data.read("cells/reach.toml").unwrap();
    let (head, _) = text.split_once("[task]").unwrap();
    let text = format!("{head}[task]\n{task}\n");
    Cell::from_text(&data, "reach", "cells/reach.toml", &text, 1, None).unwrap()
}

fn refused(policies: &Policies, cell: &Cell, policy: &str) -> String {
    match policies.task(cell, policy) {
        Ok(_) => panic!("'{policy}' was taken"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_program_knows_its_kinds_and_the_ranges_of_their_settings() {
    let policies = Policies::new().with(polish(&["slow", "fast"]));
    let job = |strokes: u32| cell(&format!("kind = \"polish\"\nstrokes = {strokes}"));
    let task = policies.task(&job(3), "fast").ok().unwrap();
    assert_eq!(task.policy_name(), "fast");
    let error = refused(&policies, &job(10), "fast");
    assert!(
        error.contains("task.strokes is 10; 1 to 9 is allowed"),
        "{error}"
    );
    let error = refused(&policies, &job(3), "fats");
    assert!(error.contains("did you mean 'fast'?"), "{error}");
    let error = refused(&policies, &cell("kind = \"polsh\""), "fast");
    assert!(
        error.contains("task.kind is 'polsh', which this task program does not know")
            && error.contains("did you mean 'polish'?"),
        "{error}"
    );
}

#[test]
fn a_kind_of_the_same_name_replaces_the_earlier_one() {
    let policies = Policies::new()
        .with(polish(&["slow"]))
        .with(polish(&["fast"]));
    assert_eq!(policies.kinds(), ["polish"]);
    let cell = cell("kind = \"polish\"\nstrokes = 3");
    assert!(policies.task(&cell, "fast").is_ok());
    assert!(matches!(
        policies.task(&cell, "slow"),
        Err(TaskError::UnknownPolicy { .. })
    ));
}

#[test]
fn a_policy_for_every_kind_does_the_task_of_any_cell_and_is_the_default() {
    let policies = Policies::new()
        .with(polish(&["slow"]))
        .policy_for_every_kind("mine", |_| Ok(boxed(Idle)));
    let cell = cell("kind = \"polish\"\nstrokes = 99\nown = true");
    assert_eq!(policies.default_policy(&cell), "mine");
    let task = policies.task(&cell, "mine").ok().unwrap();
    assert_eq!(task.policy_name(), "mine");
    let error = refused(&policies, &cell, "slow");
    assert!(
        error.contains("'slow'") && error.contains("mine"),
        "{error}"
    );
    let plain = Policies::new().with(polish(&["slow"]));
    assert_eq!(plain.default_policy(&cell), cell.default_policy);
}

#[test]
fn a_cell_without_an_arm_has_no_task() {
    let mut cell = load("reach");
    cell.arms.clear();
    let error = refused(&Policies::new().policy("idle", |_| Idle), &cell, "idle");
    assert_eq!(error, "cells/reach.toml has no [[arm]]; a task needs one");
}

#[test]
fn an_editor_is_told_the_tables_of_all_kinds() {
    let policies = Policies::new()
        .with(polish(&["slow"]))
        .with(Kind::<NoSettings>::new("rest").policy("nap", |_, _| Ok(boxed(Idle))));
    let schema = policies.cell_schema();
    let tables = schema.pointer("/$defs/TaskHead/oneOf").unwrap();
    let kinds: Vec<_> = tables
        .as_array()
        .unwrap()
        .iter()
        .map(|table| table.pointer("/properties/kind/const").unwrap())
        .collect();
    assert_eq!(kinds, ["polish", "rest"]);
    let polish = &tables[0];
    assert_eq!(polish["properties"]["strokes"]["maximum"], 9);
    let required: Vec<_> = polish["required"].as_array().unwrap().iter().collect();
    assert_eq!(required, ["strokes", "kind"]);
    assert_eq!(polish["additionalProperties"], false);
}
