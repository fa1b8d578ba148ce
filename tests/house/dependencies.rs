//! Holds the direction of dependencies of `docs/ARCHITECTURE.md` on `cargo metadata`.

use cargo_metadata::{CargoOpt, DependencyKind, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};

/// Crates of this workspace that each crate may use (not counting tests and benches).
const ALLOWED: &[(&str, &[&str])] = &[
    ("crowd-source", &[]),
    ("crowd-anim", &[]),
    ("crowd-lod", &[]),
    ("crowd-pack", &[]),
    ("crowd-raster", &[]),
    ("crowd-scene", &[]),
    ("crowd-judge", &["crowd-raster"]),
    ("crowd-stages", &["crowd-pack", "crowd-raster"]),
    ("crowdbake", &["crowd-source", "crowd-anim", "crowd-lod", "crowd-pack", "crowd-raster", "crowd-judge"]),
    ("crowdplay", &["crowd-stages", "crowd-scene", "crowd-pack", "crowd-raster"]),
    ("crowd-fixtures", &[]),
    (
        "crowd-tests",
        &[
            "crowd-source",
            "crowd-anim",
            "crowd-lod",
            "crowd-pack",
            "crowd-raster",
            "crowd-scene",
            "crowd-stages",
            "crowd-fixtures",
            "crowdbake",
            "crowdplay",
        ],
    ),
];

/// Outside crates that only the crates named may use.
const ONLY_IN: &[(&str, &[&str])] = &[
    ("wgpu", &["crowd-stages", "crowdplay", "crowd-tests"]),
    ("winit", &["crowdplay"]),
    ("gltf", &["crowd-source"]),
    ("tobj", &["crowd-source"]),
    ("bincode", &["crowd-pack"]),
];

type Graph = BTreeMap<String, BTreeSet<String>>;

/// Direct, non-test dependencies of each workspace member.
fn direct_dependencies() -> Graph {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let metadata = MetadataCommand::new()
        .manifest_path(manifest)
        .features(CargoOpt::AllFeatures)
        .no_deps()
        .exec()
        .expect("cargo metadata reads this workspace");
    metadata
        .packages
        .iter()
        .map(|package| {
            let names = package
                .dependencies
                .iter()
                .filter(|d| d.kind != DependencyKind::Development || package.name.as_str() == "crowd-tests")
                .map(|d| d.name.clone())
                .collect();
            (package.name.to_string(), names)
        })
        .collect()
}

/// Every breach of the two tables, as sentences.
fn breaches(graph: &Graph) -> Vec<String> {
    let mut found = Vec::new();
    for (name, dependencies) in graph {
        let Some((_, allowed)) = ALLOWED.iter().find(|(n, _)| n == name) else {
            found.push(format!("{name} is not in the table of docs/ARCHITECTURE.md and tests/house"));
            continue;
        };
        for dependency in dependencies {
            if graph.contains_key(dependency) && !allowed.contains(&dependency.as_str()) {
                found.push(format!("{name} -> {dependency}: allowed are {allowed:?}"));
            }
            if let Some((_, only)) = ONLY_IN.iter().find(|(n, _)| n == dependency)
                && !only.contains(&name.as_str())
            {
                found.push(format!("{name} names {dependency}, which belongs to {only:?} alone"));
            }
        }
    }
    found
}

#[test]
fn dependencies_point_the_way_of_the_architecture() {
    let graph = direct_dependencies();
    assert!(graph.len() >= ALLOWED.len(), "members found: {:?}", graph.keys());
    assert_eq!(breaches(&graph), Vec::<String>::new());
}

#[test]
fn a_wrong_direction_is_noticed() {
    let mut graph = direct_dependencies();
    graph.get_mut("crowd-lod").expect("crowd-lod is a member").insert("crowd-pack".into());
    graph.get_mut("crowd-anim").expect("crowd-anim is a member").insert("wgpu".into());
    graph.insert("crowd-extra".into(), BTreeSet::new());
    assert_eq!(breaches(&graph).len(), 3);
}
