//! The short run of every fuzz target: everything that reads what a person can type or
//! another process can send, as functions of bytes. They are here because only tests may
//! depend on all processes; the programs in `fuzz/` are built from the same files.

mod targets;

use targets::mutate::{Random, mutated};
use targets::{TARGETS, Target, target};

/// Changed inputs of each target; `ROBOCELL_FUZZ=N` sets another number.
fn count() -> usize {
    let asked = std::env::var("ROBOCELL_FUZZ").ok();
    asked.and_then(|text| text.parse().ok()).unwrap_or(400)
}

/// The input of a failure is in the file named by the message.
fn run(target: &Target, bytes: &[u8]) {
    let outcome = std::panic::catch_unwind(|| (target.run)(bytes));
    if outcome.is_err() {
        let file = std::env::temp_dir().join(format!("robocell-fuzz-{}", target.name));
        std::fs::write(&file, bytes).unwrap();
        panic!("{} fails for the bytes in {}", target.name, file.display());
    }
}

fn short(name: &str) {
    let target = target(name).unwrap();
    let corpus = (target.corpus)();
    assert!(!corpus.is_empty(), "{name} has a corpus");
    for input in &corpus {
        run(&target, input);
    }
    let mut random = Random(7);
    for _ in 0..count() {
        let input = &corpus[random.below(corpus.len())];
        run(&target, &mutated(input, &corpus, &mut random));
    }
}

/// `ROBOCELL_FUZZ_CORPUS=DIR` writes the corpora where cargo-fuzz reads them.
#[test]
fn write_the_corpora() {
    let Some(dir) = std::env::var_os("ROBOCELL_FUZZ_CORPUS") else {
        eprintln!("not asked: ROBOCELL_FUZZ_CORPUS names no directory");
        return;
    };
    for target in &TARGETS {
        let dir = std::path::Path::new(&dir).join(target.name);
        std::fs::create_dir_all(&dir).unwrap();
        for (number, input) in (target.corpus)().iter().enumerate() {
            std::fs::write(dir.join(format!("valid-{number}")), input).unwrap();
        }
    }
}

macro_rules! short {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            short(stringify!($name));
        })*

        #[test]
        fn every_target_is_run() {
            let names = [$(stringify!($name)),*];
            assert_eq!(TARGETS.map(|target| target.name), names);
        }
    };
}
short! { cell tree machine matrix urdf xrdf tuning script command policy_answer message recording checkpoint fci_stream fci_datagram }
