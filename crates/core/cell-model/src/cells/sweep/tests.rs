use super::*;

const TEXT: &str = "[[object]]\nname = \"red\"\nmass = 1.0\n[[object]]\nname = \"blue\"\n\
    mass = 1\n[task]\nattempts = 3\n";

fn sweep(set: &[&str], vary: &[&str]) -> Sweep {
    Sweep {
        set: set.iter().map(|text| text.parse().unwrap()).collect(),
        vary: vary.iter().map(|text| text.parse().unwrap()).collect(),
        ..Sweep::default()
    }
}

fn words(settings: &[Setting]) -> String {
    let words: Vec<String> = settings.iter().map(Setting::to_string).collect();
    words.join(" ")
}

#[test]
fn every_combination_is_a_variant() {
    let both = sweep(&["a=1,2.5", "b=3,4,5"], &[]);
    let all: Vec<String> = both.variants().map(|v| words(&both.variant(v).0)).collect();
    assert_eq!(
        all,
        [
            "a=1 b=3",
            "a=1 b=4",
            "a=1 b=5",
            "a=2.5 b=3",
            "a=2.5 b=4",
            "a=2.5 b=5"
        ]
    );
    let cases = both.cases("c.toml", "").unwrap();
    let samples: Vec<String> = cases.samples(1).iter().map(|c| words(&c.set)).collect();
    assert_eq!(samples, ["a=1 b=3", "a=2.5 b=3", "a=1 b=4", "a=1 b=5"]);
    assert_eq!(Sweep::default().variants(), 0..=0);
    assert_eq!(Cases::default().case(7, 0).settings(), []);
    let many = vec!["a=1,2,3,4,5,6,7,8,9,10"; 5];
    let error = sweep(&many, &[])
        .cases("c.toml", "")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("100000 combinations; at most 10000"),
        "{error}"
    );
}

#[test]
fn latencies_and_faults_are_variants_as_well() {
    let all = Sweep {
        latencies_ms: vec![0, 200],
        faults: vec!["drop@0..500".parse().unwrap()],
        ..sweep(&["a=1,2"], &[])
    };
    assert_eq!(all.variants(), 1..=8);
    let (set, latency_ms, fault) = all.variant(4);
    assert_eq!(words(&set), "a=1");
    assert_eq!(latency_ms, Some(200));
    assert_eq!(fault.unwrap().to_string(), "drop@0..500");
    let (set, latency_ms, fault) = all.variant(5);
    assert_eq!((words(&set).as_str(), latency_ms), ("a=2", Some(0)));
    assert_eq!(fault, None);
    // A single latency makes no variants.
    let one = Sweep {
        latencies_ms: vec![100],
        ..Sweep::default()
    };
    assert_eq!((one.variants(), one.variant(0).1), (0..=0, Some(100)));
}

#[test]
fn numbers_are_drawn_within_their_bounds_and_depend_on_seed_and_path_alone() {
    let of = |vary: &[&str]| sweep(&[], vary).cases("c.toml", TEXT).unwrap();
    let few = of(&["object.*.mass=0.5..1.5"]);
    let more = of(&["task.attempts=1..4", "object.*.mass=0.5..1.5"]);
    let first = words(&few.case(1, 0).drawn);
    // Of another implementation of SplitMix64 and FNV-1a.
    assert_eq!(
        first,
        "object.red.mass=0.8431386287067437 object.blue.mass=1.0675667983811343"
    );
    let mut seen = std::collections::BTreeSet::new();
    for seed in 0..200 {
        let (few, all) = (few.case(seed, 0).drawn, more.case(seed, 0).drawn);
        assert_eq!(few[..], all[1..]);
        let value = |setting: &Setting| setting.value.as_f64().unwrap();
        assert!(few.iter().all(|one| (0.5..1.5).contains(&value(one))));
        assert_ne!(few[0].value, few[1].value);
        seen.insert(all[0].value.as_i64().unwrap());
    }
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), [1, 2, 3, 4]);
}

#[test]
fn what_has_no_bounds_or_values_is_refused() {
    for bad in [
        "a=1", "a=2..1", "a=1..1", "a=..", "a=1..inf", "a b=1..2", "=1..2",
    ] {
        assert!(bad.parse::<Bounds>().is_err(), "{bad}");
    }
    for bad in ["a", "a=", "a=1,,2", "a=1,x", "a=nan"] {
        assert!(bad.parse::<Values>().is_err(), "{bad}");
    }
}
