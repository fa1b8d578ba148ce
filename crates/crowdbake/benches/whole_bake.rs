//! Where the time of a whole bake goes: step by step, beside the order alone and beside meshoptimizer's levels at the same counts.
//!
//! `cargo bench -p crowdbake --bench whole_bake -- FILE... [--rounds N]`: prints a table. On one thread, so that seconds are those of the processor;
//! rounds go through all rows in turn and each figure is the least of them, since other work on a machine only adds.

use crowd_pack::ManifestTarget;
use crowdbake::bake::StepTime;
use crowdbake::lod_target::LodTarget;
use crowdbake::plan::PlanEntry;
use crowdbake::{BakedCharacter, Step, bake_character};
use std::path::PathBuf;
use std::time::Instant;

/// The levels that are refitted in the rows that refit.
const REFITTED: [f32; 4] = [0.5, 0.25, 0.1, 0.05];

/// A file, baked in one way.
struct Row {
    entry: PlanEntry,
    triangles: usize,
    /// Least seconds: of each step, and of meshoptimizer's levels.
    steps: Vec<StepTime>,
    by_meshopt: f64,
}

fn main() {
    let (mut paths, mut rounds) = (Vec::new(), 3);
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        if word == "--rounds" {
            rounds = words.next().and_then(|count| count.parse().ok()).expect("--rounds takes a number");
        } else {
            paths.push(PathBuf::from(word));
        }
    }
    if paths.is_empty() {
        println!("nothing to bake: cargo bench -p crowdbake --bench whole_bake -- FILE...");
        return;
    }
    // Cargo runs benches in the folder of their crate.
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let entry = |path: &PathBuf, refit: bool| {
        let path = if path.exists() { path.clone() } else { root.join(path) };
        let mut entry = PlanEntry::of_file(&path);
        entry.levels.refit = refit;
        if refit {
            entry.levels.targets = REFITTED.map(|share| LodTarget(ManifestTarget::Ratio(share))).to_vec();
        }
        Row { entry, triangles: 0, steps: Vec::new(), by_meshopt: f64::INFINITY }
    };
    let mut rows: Vec<Row> = paths.iter().flat_map(|path| [entry(path, false), entry(path, true)]).collect();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    for _ in 0..rounds {
        rows.iter_mut().for_each(|row| alone.install(|| measure(row)));
    }
    println!(
        "| character | triangles | whole bake, s | of it reading and sampling | order | levels | whole bake / order | / meshoptimizer's levels |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    rows.iter().for_each(print);
}

fn measure(row: &mut Row) {
    let baked = bake_character(&row.entry, false, &|_, _| {}).expect("a character that bakes");
    row.triangles = baked.raw.mesh.triangles.len();
    if row.steps.is_empty() {
        row.steps.clone_from(&baked.steps);
    }
    for (known, new) in row.steps.iter_mut().zip(&baked.steps) {
        known.seconds = known.seconds.min(new.seconds);
    }
    row.by_meshopt = row.by_meshopt.min(levels_by_meshopt(&baked));
}

/// Seconds that meshoptimizer takes for all levels that the pack stores, each from full detail, with normals as gltfpack weighs them.
fn levels_by_meshopt(baked: &BakedCharacter) -> f64 {
    let mesh = &baked.raw.mesh;
    let positions: &[u8] = bytemuck::cast_slice(&mesh.positions);
    let vertices = meshopt::VertexDataAdapter::new(positions, 12, 0).expect("whole positions");
    let locks = vec![false; mesh.positions.len()];
    let discrete = baked.levels.discrete.iter().map(|discrete| &discrete.level);
    let counts: Vec<usize> = baked.levels.quantized.iter().chain(discrete).map(|level| level.indices.len()).collect();
    let started = Instant::now();
    let kept: usize = counts
        .iter()
        .map(|&count| {
            meshopt::simplify_with_attributes_and_locks(
                mesh.triangles.as_flattened(),
                &vertices,
                mesh.normals.as_flattened(),
                &[0.5; 3],
                12,
                &locks,
                count,
                1.0,
                meshopt::SimplifyOptions::None,
                None,
            )
            .len()
        })
        .sum();
    std::hint::black_box(kept);
    started.elapsed().as_secs_f64()
}

fn print(row: &Row) {
    let of = |wanted: &[Step]| -> f64 {
        row.steps.iter().filter(|time| wanted.contains(&time.step)).map(|time| time.seconds).sum()
    };
    let whole: f64 = row.steps.iter().map(|time| time.seconds).sum();
    let (order, levels) = (of(&[Step::Simplify]), of(&[Step::Levels]));
    println!(
        "| {}{} | {} | {whole:.2} | {:.2} | {order:.2} | {levels:.2} | {:.1} | {:.1} |",
        row.entry.name,
        if row.entry.levels.refit { ", four levels refitted" } else { "" },
        row.triangles,
        whole - order - levels,
        whole / order,
        whole / row.by_meshopt,
    );
}
