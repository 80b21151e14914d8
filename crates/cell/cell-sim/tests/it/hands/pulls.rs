//! A person pulls at an object while the hand sets it down, at moments drawn from the seed.

use cell_model::random::Random;

use super::{Situation, series};

/// Where an object is set down in a demo.
struct Placing {
    demo: &'static str,
    policy: &'static str,
    bins: u32,
    /// Phase, its occurrence, the object, and where it belongs (m).
    steps: Vec<(&'static str, u32, &'static str, [f64; 3])>,
    /// The pull begins that long after the start of the phase (s).
    after_s: [f64; 2],
    /// Least and largest offset of the pull along x (m): what is out of reach cannot be placed.
    along_x_m: [f64; 2],
}

fn between(random: &mut Random, [low, high]: [f64; 2]) -> f64 {
    low + random.share() * (high - low)
}

/// Pulls by up to 0.1 m for up to 2 s, one in each run.
fn pulls(of: &Placing, seeds: std::ops::RangeInclusive<u64>) -> Vec<Situation> {
    let pull = |seed: u64| {
        let random = &mut Random::new(2000 + seed);
        let share = random.share() * of.steps.len() as f64;
        let index = (0..of.steps.len())
            .rev()
            .find(|index| *index as f64 <= share);
        let (phase, nth, object, [x, y, z]) = of.steps[index.unwrap()];
        let after_s = between(random, of.after_s);
        let to = [
            x + between(random, of.along_x_m),
            y + between(random, [-0.1, 0.1]),
            z + between(random, [0.0, 0.1]),
        ];
        let for_s = between(random, [0.1, 2.0]);
        let mut one = Situation::new("pulled", of.demo, of.policy)
            .bins(of.bins)
            .seed(seed);
        // A bin that is torn off falls from a metre, and may lean or be out of reach then.
        if of.bins > 0 {
            one = one.or(&["bin_cannot_be_gripped", "bin_out_of_reach"]);
        }
        // The filled bin breaks off and lands upright or on its side: parts that it keeps cover
        // its floor.
        if of.demo == "ur10-fill-bin" {
            one = one.or(&["bin_cannot_be_gripped"]);
        }
        one.script = format!(
            "{{\"at_phase\": \"{phase}\", \"nth\": {nth}, \"after_s\": {after_s:.3}, \
             \"do\": \"drag\", \"object\": \"{object}\", \"to\": {to:?}, \"for_s\": {for_s:.3}}}\n"
        );
        one
    };
    seeds.map(pull).collect()
}

fn cube() -> Placing {
    Placing {
        demo: "cube",
        policy: "tree",
        bins: 0,
        steps: vec![("lower", 1, "cube", [0.5, 0.25, 0.025])],
        after_s: [0.0, 0.9],
        along_x_m: [-0.1, 0.1],
    }
}

fn stack(policy: &'static str) -> Placing {
    let steps = (1..).zip(["red_cube", "blue_cube", "green_cube", "yellow_cube"]);
    Placing {
        demo: "franka-stack",
        policy,
        bins: 0,
        steps: steps
            .map(|(nth, cube)| {
                let z = 0.05 * f64::from(nth) - 0.025;
                ("LOWER", nth, cube, [0.55, 0.2, z])
            })
            .collect(),
        after_s: [0.0, 1.6],
        along_x_m: [-0.1, 0.1],
    }
}

fn pyramid() -> Placing {
    let left = ["cube_1", "cube_2", "cube_4"].map(|cube| ("LEFT_LOWER", cube, -0.28));
    let right = ["cube_3", "cube_6", "cube_5"].map(|cube| ("RIGHT_LOWER", cube, 0.28));
    let numbered = [left, right].map(|cubes| (1..).zip(cubes));
    let steps = numbered
        .into_iter()
        .flatten()
        .map(|(nth, (phase, cube, y))| {
            (phase, nth, cube, [0.46, y, 0.05 * f64::from(nth) - 0.025])
        });
    Placing {
        demo: "franka-pyramid",
        policy: "json",
        bins: 0,
        steps: steps.collect(),
        after_s: [0.0, 1.4],
        along_x_m: [-0.1, 0.1],
    }
}

fn bin_stack() -> Placing {
    Placing {
        demo: "ur10-bin-stack",
        policy: "matrix",
        bins: 2,
        steps: vec![
            ("PLACING", 1, "bin_01", [0.95, -0.63, -0.38]),
            ("PLACING", 2, "bin_02", [0.95, -0.63, -0.245]),
        ],
        after_s: [3.0, 8.5],
        along_x_m: [-0.1, 0.02],
    }
}

fn palletize() -> Placing {
    Placing {
        demo: "ur10-palletize",
        policy: "table",
        bins: 2,
        steps: vec![
            ("ReachToPlace", 1, "bin_01", [1.05, -0.62, -0.36]),
            ("ReachToPlace", 2, "bin_02", [1.05, -0.31, -0.36]),
        ],
        after_s: [2.0, 6.5],
        along_x_m: [-0.1, 0.0],
    }
}

fn fill_bin() -> Placing {
    Placing {
        demo: "ur10-fill-bin",
        policy: "matrix",
        bins: 0,
        steps: vec![
            ("ATTACH", 1, "bin", [0.0, 0.81, -0.3]),
            ("HOLDING", 1, "bin", [0.0, 0.81, 0.5]),
        ],
        after_s: [0.0, 3.0],
        along_x_m: [-0.1, 0.1],
    }
}

/// In seed 71,239 of six cubes into two trays the hand had opened a little when a person pulled the
/// cube against a finger: it was in its place, and then in the hand.
#[test]
fn a_cube_that_is_pulled_out_of_the_opening_hand_is_brought_back() {
    let mut one = Situation::new("sort", "sort", "tree").seed(71_239).pull(
        18.0,
        "red_3",
        [0.45, 0.02, 0.02],
        2.0,
    );
    one.data = Some(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/scenes"));
    series([one]);
}

#[test]
fn what_is_pulled_at_while_it_is_set_down_is_brought_back() {
    series(
        [cube(), stack("fsm"), pyramid()]
            .iter()
            .flat_map(|demo| pulls(demo, 1..=2)),
    );
}

#[test]
#[ignore = "slow: .ci/long"]
fn twenty_pulls_at_each_placing_end_done_or_with_the_true_reason() {
    let all = [
        cube(),
        stack("fsm"),
        stack("ifelse"),
        stack("bt"),
        pyramid(),
        bin_stack(),
        palletize(),
        fill_bin(),
    ];
    series(all.iter().flat_map(|demo| pulls(demo, 1..=20)));
}
