//! Most lines of code of the main packages, of the optional ones, of one package and of the page.
//! A change that adds more removes as many elsewhere.

use std::collections::BTreeMap;

use super::comments::{code_lines, package};
use super::{collect, files, is_test, root, split};

/// `core`, `tasks`, `cell`, the processes, the command line, Python and the tools.
const MAIN: usize = 102_920;
/// Gateways, formats, benches and fuzz programs: each can be left out.
const OPTIONAL: usize = 15_000;
const PACKAGE: usize = 13_500;
/// TypeScript without comments, and CSS with them.
const PAGE: usize = 19_690;

fn is_optional(package: &str) -> bool {
    let folders = ["crates/gateways/", "crates/formats/"];
    let programs = ["crates/tools/benches", "fuzz"];
    folders.iter().any(|folder| package.starts_with(folder)) || programs.contains(&package)
}

#[test]
fn packages_keep_their_budgets() {
    let mut packages: BTreeMap<String, usize> = BTreeMap::new();
    for (path, text) in files().iter().filter(|(path, _)| !is_test(path)) {
        *packages.entry(package("rs", path)).or_default() += code_lines(text).0;
    }
    let sum = |wanted| {
        let of = packages
            .iter()
            .filter(|(name, _)| is_optional(name) == wanted);
        of.map(|(_, lines)| lines).sum::<usize>()
    };
    let (main, optional) = (sum(false), sum(true));
    assert!(main > 50_000 && optional > 5_000, "{packages:#?}");
    assert!(
        main <= MAIN,
        "{main} lines, allowed are {MAIN}: {packages:#?}"
    );
    assert!(
        optional <= OPTIONAL,
        "{optional} lines, allowed are {OPTIONAL}: {packages:#?}"
    );
    let large = packages.iter().filter(|(_, lines)| **lines > PACKAGE);
    let large: Vec<_> = large.collect();
    assert!(large.is_empty(), "more than {PACKAGE} lines: {large:?}");
}

#[test]
fn the_page_keeps_its_budget() {
    let ui = root().join("monitor-proc/ui/src");
    let mut files = BTreeMap::new();
    collect(&ui, "ts", &mut files);
    let scripts = files.values().map(|text| split(text).0);
    let mut sheets = BTreeMap::new();
    collect(&ui, "css", &mut sheets);
    let all = scripts.chain(sheets.into_values());
    let lines = all
        .map(|text| text.lines().filter(|line| !line.trim().is_empty()).count())
        .sum::<usize>();
    assert!(
        lines > 5_000 && lines <= PAGE,
        "{lines} lines, allowed are {PAGE}"
    );
}
