//! Simplification of 100,000 triangles over 500 frames, and next to it meshoptimizer's on the same mesh.
//!
//! `cargo bench -p crowd-lod --bench simplify`. Figures with their machine: `docs/benchmarks/speed.md`.

mod snake;

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use crowd_lod::{Criteria, FrameChoice, LodMesh, LodOptions, simplify};
use snake::{Snake, Waves};
use std::time::Duration;

/// Meshoptimizer's simplifier with normals as attributes, as gltfpack calls it: down to `target` triangles.
fn simplify_by_meshopt(mesh: &LodMesh<'_>, target: usize) -> usize {
    let positions: &[u8] = bytemuck::cast_slice(mesh.positions);
    let vertices = meshopt::VertexDataAdapter::new(positions, 12, 0).expect("whole positions");
    let indices: &[u32] = mesh.triangles.as_flattened();
    let locks = vec![false; mesh.positions.len()];
    let kept = meshopt::simplify_with_attributes_and_locks(
        indices,
        &vertices,
        mesh.normals.as_flattened(),
        &[0.5; 3],
        12,
        &locks,
        target * 3,
        1.0,
        meshopt::SimplifyOptions::None,
        None,
    );
    kept.len() / 3
}

fn benches(c: &mut Criterion) {
    let snake = Snake::new(200, 250);
    let mesh = snake.mesh();
    let (waves_500, waves_64) = (Waves::new(5, 100), Waves::new(4, 16));
    let with = |frames: FrameChoice| LodOptions { frames, ..LodOptions::default() };
    let every_frame = with(FrameChoice::All);
    let paper = LodOptions { criteria: Criteria::Peng2011, ..every_frame.clone() };

    let mut group = c.benchmark_group("100,000 triangles");
    group.sample_size(10).sampling_mode(SamplingMode::Flat).measurement_time(Duration::from_secs(15));
    for (name, waves, options) in [
        ("500 frames, default", &waves_500, &with(FrameChoice::Auto)),
        ("500 frames, --frames all", &waves_500, &with(FrameChoice::All)),
        ("500 frames, --frames bind", &waves_500, &with(FrameChoice::Bind)),
        ("64 frames", &waves_64, &every_frame),
        ("64 frames, peng2011", &waves_64, &paper),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| simplify(&mesh, &waves.poses(), options, &|_| ()).expect("the snake is a valid mesh"));
        });
    }
    // The order holds every level, so the peer is asked for the deepest one of its table, and for a chain of four.
    group.bench_function("meshoptimizer to 2 %", |b| b.iter(|| simplify_by_meshopt(&mesh, 2_000)));
    let chain = [50_000, 25_000, 10_000, 2_000];
    group.bench_function("meshoptimizer to 50, 25, 10 and 2 %", |b| {
        b.iter(|| chain.map(|target| simplify_by_meshopt(&mesh, target)));
    });
    group.finish();
}

criterion_group!(simplification, benches);
criterion_main!(simplification);
