//! A test that crates depend on each other only as ARCHITECTURE.md allows, checked with cargo's metadata.

use std::collections::{BTreeMap, BTreeSet};

use crate::packages::{self, Package};
use crate::workspace;

/// The crates of ours that each crate of ours may depend on.
type Arrows = BTreeMap<String, BTreeSet<String>>;

/// Reads the arrows from ARCHITECTURE.md: the lines `crate -> crate, crate` of its block ```` ```arrows ````.
fn allowed(document: &str) -> Result<Arrows, String> {
    let mut lines = document.lines().skip_while(|line| line.trim() != "```arrows");
    lines.next().ok_or("ARCHITECTURE.md has no block ```arrows")?;
    let mut arrows = Arrows::new();
    for line in lines.take_while(|line| line.trim() != "```") {
        let (from, to) = line
            .split_once("->")
            .ok_or_else(|| format!("ARCHITECTURE.md: `{line}`: expected `crate -> crates`"))?;
        let to = to
            .split(',')
            .map(|name| name.trim().to_owned())
            .filter(|name| !name.is_empty() && name != "nothing");
        arrows.insert(from.trim().to_owned(), to.collect());
    }
    Ok(arrows)
}

/// Differences between the tree and what is allowed, one line each.
fn violations(allowed: &Arrows, found: &Arrows) -> Vec<String> {
    let mut lines = Vec::new();
    for (from, dependencies) in found {
        let Some(permitted) = allowed.get(from) else {
            lines.push(format!("`{from}` is missing from ARCHITECTURE.md: list there what it may depend on"));
            continue;
        };
        for to in dependencies.difference(permitted) {
            lines.push(format!("`{from}` depends on `{to}`, which ARCHITECTURE.md does not allow"));
        }
    }
    for name in allowed.keys().filter(|name| !found.contains_key(*name)) {
        lines.push(format!("ARCHITECTURE.md names `{name}`, which is not a crate of the workspace"));
    }
    lines
}

/// The dependencies of the workspace's crates on one another.
fn found(packages: &[Package]) -> Arrows {
    let names: BTreeSet<_> = packages.iter().map(|package| &package.name).collect();
    let ours = |package: &Package| {
        let dependencies = package.dependencies.iter().map(|dependency| &dependency.name);
        // A crate's own tests may depend on it, to enable a feature.
        let others = dependencies.filter(|name| names.contains(name) && **name != package.name);
        others.cloned().collect()
    };
    packages.iter().map(|package| (package.name.clone(), ours(package))).collect()
}

#[test]
fn every_dependency_is_one_that_the_architecture_allows() {
    let document = std::fs::read_to_string(workspace::root().join("ARCHITECTURE.md")).unwrap();
    let arrows = found(&packages::all().unwrap());
    assert!(arrows["pylon"].contains("kf-core"), "pylon no longer depends on kf-core: {arrows:?}");
    assert_eq!(violations(&allowed(&document).unwrap(), &arrows), Vec::<String>::new());
}

fn arrows(lines: &[&str]) -> Arrows {
    allowed(&format!("text\n```arrows\n{}\n```\nmore -> text", lines.join("\n"))).unwrap()
}

#[test]
fn a_forbidden_dependency_is_named() {
    let allowed = arrows(&["kf-core -> nothing", "pylon -> kf-core, model", "model -> kf-core"]);
    let found = arrows(&["kf-core -> pylon", "pylon -> kf-core", "model -> kf-core"]);
    assert_eq!(
        violations(&allowed, &found),
        ["`kf-core` depends on `pylon`, which ARCHITECTURE.md does not allow"]
    );
}

#[test]
fn a_crate_that_the_document_does_not_know_or_that_is_gone_is_named() {
    let violations = violations(&arrows(&["gone -> nothing"]), &arrows(&["new -> nothing"]));
    assert_eq!(violations.len(), 2, "{violations:?}");
}

#[test]
fn a_document_without_arrows_is_refused() {
    assert!(allowed("# Architecture\n").is_err());
    assert!(allowed("```arrows\nkf-core\n```\n").is_err());
}
