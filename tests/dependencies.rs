//! Is every package that raybudget is built and tested with allowed by `dependency-policy.toml`?

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// The platform whose packages are judged, on every host, so that the answer depends on `Cargo.lock` alone.
const PLATFORM: &str = "x86_64-unknown-linux-gnu";

struct Package {
    name: String,
    version: String,
    licence: Option<String>,
    links: bool,
}

/// The external packages of the workspace: normal, build and dev-dependencies.
fn packages() -> Vec<Package> {
    let metadata = |more: &[&str]| {
        Command::new(env!("CARGO"))
            .args(["metadata", "--format-version", "1", "--locked", "--filter-platform", PLATFORM])
            .args(["--manifest-path", concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")])
            .args(more)
            .output()
            .expect("cargo starts")
    };
    // A platform other than the host's may have packages that were never downloaded.
    let output = Some(metadata(&["--offline"])).filter(|output| output.status.success());
    let output = output.unwrap_or_else(|| metadata(&[]));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON");
    let text = |value: &Value| value.as_str().map(str::to_owned);
    metadata["packages"]
        .as_array()
        .expect("a list of packages")
        .iter()
        .filter(|package| !package["source"].is_null())
        .map(|package| Package {
            name: text(&package["name"]).expect("a name"),
            version: text(&package["version"]).expect("a version"),
            licence: text(&package["license"]),
            links: package["links"].is_string(),
        })
        .collect()
}

struct Policy {
    licences: BTreeSet<String>,
    links: BTreeSet<String>,
    several_versions: BTreeSet<String>,
}

fn policy() -> Policy {
    let text = include_str!("../dependency-policy.toml");
    let table: toml::Table = text.parse().expect("dependency-policy.toml is TOML");
    let known = ["licences", "links", "several_versions"];
    assert!(table.keys().map(String::as_str).eq(known), "expected exactly the keys {known:?}");
    let listed = |key: &str| {
        let mut names = BTreeSet::new();
        for entry in table[key].as_array().expect("a list of tables") {
            let name = entry["package"].as_str().expect("the name of a package");
            assert!(
                entry["reason"].as_str().is_some_and(|reason| !reason.is_empty()),
                "{key}: {name}: no reason"
            );
            assert!(names.insert(name.to_owned()), "{key}: {name} is listed twice");
        }
        names
    };
    let licences = table["licences"].as_array().expect("a list of licences").iter();
    Policy {
        licences: licences.map(|licence| licence.as_str().expect("an SPDX id").to_owned()).collect(),
        links: listed("links"),
        several_versions: listed("several_versions"),
    }
}

/// An SPDX licence expression; `/`, the old way to write OR, is understood too.
struct Expression<'a> {
    words: Vec<&'a str>,
    at: usize,
}

impl<'a> Expression<'a> {
    /// Whether the allowed licences satisfy an expression.
    fn is_satisfied(text: &str, allowed: &BTreeSet<String>) -> bool {
        let spaced = text.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
        let mut expression = Expression { words: spaced.split_whitespace().collect(), at: 0 };
        let satisfied = expression.either(allowed);
        assert_eq!(expression.at, expression.words.len(), "not a licence expression: {text}");
        satisfied
    }

    fn next(&mut self) -> &'a str {
        self.at += 1;
        self.words
            .get(self.at - 1)
            .unwrap_or_else(|| panic!("a licence expression ends early: {:?}", self.words))
    }

    fn take(&mut self, word: &str) -> bool {
        let found = self.words.get(self.at) == Some(&word);
        self.at += usize::from(found);
        found
    }

    fn either(&mut self, allowed: &BTreeSet<String>) -> bool {
        let mut satisfied = self.both(allowed);
        while self.take("OR") {
            satisfied |= self.both(allowed);
        }
        satisfied
    }

    fn both(&mut self, allowed: &BTreeSet<String>) -> bool {
        let mut satisfied = self.single(allowed);
        while self.take("AND") {
            satisfied &= self.single(allowed);
        }
        satisfied
    }

    fn single(&mut self, allowed: &BTreeSet<String>) -> bool {
        if self.take("(") {
            let satisfied = self.either(allowed);
            assert!(self.take(")"), "a parenthesis is not closed: {:?}", self.words);
            return satisfied;
        }
        let mut licence = self.next().to_owned();
        if self.take("WITH") {
            licence = format!("{licence} WITH {}", self.next());
        }
        allowed.contains(&licence)
    }
}

/// Versions with the same text are interchangeable for cargo (`^`).
fn compatibility(version: &str) -> String {
    let numbers: Vec<&str> = version.split(['.', '-', '+']).take(3).collect();
    let leading_zeros = numbers.iter().take_while(|&&number| number == "0").count();
    numbers[..numbers.len().min(leading_zeros + 1)].join(".")
}

/// Says what was found beyond the list, and what was listed and not found.
fn assert_same(what: &str, found: &BTreeSet<String>, listed: &BTreeSet<String>) {
    let unlisted = found - listed;
    let stale = listed - found;
    assert!(unlisted.is_empty(), "{what}: not in dependency-policy.toml: {unlisted:?}");
    assert!(
        stale.is_empty(),
        "{what}: in dependency-policy.toml, but no package needs it any more: {stale:?}"
    );
}

#[test]
fn every_package_can_be_used_under_an_allowed_licence_and_every_allowed_licence_is_needed() {
    let allowed = policy().licences;
    let packages = packages();
    let refused = |allowed: &BTreeSet<String>| -> Vec<String> {
        let refuses = |licence: &String| !Expression::is_satisfied(licence, allowed);
        let refused = packages.iter().filter(|package| package.licence.as_ref().is_none_or(refuses));
        refused
            .map(|Package { name, version, licence, .. }| format!("{name} {version}: {licence:?}"))
            .collect()
    };
    assert_eq!(refused(&allowed), [""; 0], "packages without an allowed licence");
    for licence in &allowed {
        let others = &allowed - &BTreeSet::from([licence.clone()]);
        assert!(!refused(&others).is_empty(), "{licence} is allowed, but no package needs it any more");
    }
}

#[test]
fn every_package_that_claims_a_native_library_has_a_reason() {
    let found = packages().into_iter().filter(|package| package.links).map(|package| package.name).collect();
    assert_same("links", &found, &policy().links);
}

#[test]
fn every_package_in_incompatible_versions_has_a_reason() {
    let mut versions = BTreeMap::<String, BTreeSet<String>>::new();
    for Package { name, version, .. } in packages() {
        versions.entry(name).or_default().insert(compatibility(&version));
    }
    let found =
        versions.into_iter().filter(|(_, versions)| versions.len() > 1).map(|(name, _)| name).collect();
    assert_same("several_versions", &found, &policy().several_versions);
}

#[test]
fn licence_expressions_are_understood() {
    let allowed = BTreeSet::from(["MIT", "Zlib", "Unicode-3.0"].map(str::to_owned));
    let satisfied = |text| Expression::is_satisfied(text, &allowed);
    assert!(satisfied("MIT") && satisfied("GPL-3.0-only OR MIT") && satisfied("Unlicense/MIT"));
    assert!(satisfied("(GPL-3.0-only OR MIT) AND Unicode-3.0") && satisfied("GPL-3.0-only OR MIT AND Zlib"));
    assert!(satisfied("Apache-2.0 WITH LLVM-exception OR MIT"));
    assert!(!satisfied("GPL-3.0-only") && !satisfied("MIT AND GPL-3.0-only"));
    assert!(!satisfied("MIT WITH some-exception") && !satisfied("(MIT OR Zlib) AND GPL-3.0-only"));
}

#[test]
fn versions_are_compatible_as_cargo_takes_them() {
    let versions = ["1.2.3", "0.14.4", "0.0.5", "2.1.3+zstd.1.5.7", "3.0.0-rc.1"];
    assert_eq!(versions.map(compatibility), ["1", "0.14", "0.0.5", "2", "3"]);
}
