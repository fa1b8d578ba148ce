//! `test_occlusion` on the GPU against its twin: equal, but for boxes at the edge of the outcome.

use crate::cases::Case;
use crate::occlusion::{HEIGHT, Street, WIDTH, street};
use crowd_stages::{CullRecord, PyramidConfig, cpu, gpu::TestOcclusion, sight};
use crowd_tests::gpu;

type Tested = (Vec<CullRecord>, Vec<u32>);

/// A street with half of its people drawn, the other half waiting, and the pyramid over the former.
struct Scene {
    case: Case,
    pyramid: PyramidConfig,
    farthest: Vec<f32>,
    culled: Vec<CullRecord>,
    seen: Vec<u32>,
}

fn scene() -> Scene {
    let street: &Street = street();
    let config = street.config(0);
    let mut culled = cpu::cull_instances(&street.data, &street.instances, &config);
    let mut seen = vec![street.instances.len() as u32];
    seen.extend((0..culled.len()).map(|i| if i % 2 == 0 { sight::SEEN } else { sight::HIDDEN }));
    cpu::recall_seen(&street.data, &street.instances, &seen, &mut culled, &config);
    let drawn: Vec<usize> = (0..culled.len()).filter(|i| culled[*i].visible != 0).collect();
    let pyramid = PyramidConfig::new(WIDTH, HEIGHT, 1);
    let farthest = cpu::build_pyramid(&pyramid, &street.owners(&config, &drawn).depth);
    let case = Case { data: &street.data, instances: street.instances.clone(), config };
    Scene { case, pyramid, farthest, culled, seen }
}

fn on_gpu(scene: &Scene) -> Tested {
    let Scene { case, .. } = scene;
    let stage = TestOcclusion::new(&gpu::device().0);
    let (culled, seen) = (gpu::storage(&scene.culled), gpu::storage(&scene.seen));
    let bound = stage.bind(
        &gpu::device().0,
        &gpu::uniform(&case.config),
        &gpu::uniform(&scene.pyramid),
        &gpu::storage(&case.instances),
        &gpu::storage(&case.data.characters),
        &gpu::storage(&case.data.clips),
        &gpu::storage(&scene.farthest),
        &culled,
        &seen,
    );
    gpu::run(|pass| stage.record(pass, &bound, case.count()));
    (gpu::read(&culled, scene.culled.len()), gpu::read(&seen, scene.seen.len()))
}

fn on_cpu(scene: &Scene) -> Tested {
    let Scene { case, pyramid, farthest, .. } = scene;
    let (mut culled, mut seen) = (scene.culled.clone(), scene.seen.clone());
    cpu::test_occlusion(case.data, &case.instances, pyramid, farthest, &mut culled, &mut seen, &case.config);
    (culled, seen)
}

/// Whether another rounding of the box may change the outcome.
fn is_borderline(scene: &Scene, i: usize) -> bool {
    let Scene { case, pyramid, farthest, .. } = scene;
    let Some(screen) = cpu::screen_box(case.data, &case.instances[i], &case.config, pyramid) else { return true };
    let (edge, depth) = cpu::EDGE_BOUNDS;
    let hidden = |px: f32, nearer: f32| {
        let moved =
            cpu::ScreenBox { least: screen.least - px, most: screen.most + px, nearest: screen.nearest - nearer };
        cpu::is_hidden(&moved, pyramid, farthest)
    };
    hidden(edge, depth) != hidden(-edge, -depth)
}

fn difference(scene: &Scene, gpu: &Tested, cpu: &Tested) -> Option<String> {
    let agrees = |i: &usize| (gpu.0[*i] == cpu.0[*i] && gpu.1[1 + i] == cpu.1[1 + i]) || is_borderline(scene, *i);
    let i = (0..cpu.0.len()).find(|i| !agrees(i))?;
    Some(format!("instance {i}: {:?} on the GPU, {:?} on the CPU", (gpu.0[i], gpu.1[1 + i]), (cpu.0[i], cpu.1[1 + i])))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn the_test_agrees_in_a_street() {
    let scene = scene();
    let expected = on_cpu(&scene);
    assert_eq!(difference(&scene, &on_gpu(&scene), &expected), None);
    let count = |word: u32| expected.1[1..].iter().filter(|found| **found == word).count();
    let kinds = [sight::SEEN | sight::DRAWN, sight::HIDDEN | sight::DRAWN, sight::HIDDEN, 0].map(count);
    assert!(kinds.iter().all(|count| *count > 20), "each outcome is worth testing: {kinds:?}");

    // A camera whose depth is 1 near and 0 far: the pyramid is the same, and so is the outcome.
    let mut reversed = scene;
    reversed.pyramid.reversed = 1;
    for column in &mut reversed.case.config.clip_from_world {
        column[2] = column[3] - column[2];
    }
    let turned = on_cpu(&reversed);
    assert_eq!(difference(&reversed, &on_gpu(&reversed), &turned), None);
    assert_eq!(difference(&reversed, &turned, &expected), None);
    reversed.pyramid.reversed = 0;
    assert!(difference(&reversed, &on_cpu(&reversed), &expected).is_some(), "it has to be told");
}

#[test]
fn a_changed_outcome_is_seen_and_few_are_borderline() {
    let scene = scene();
    let expected = on_cpu(&scene);
    let sure: Vec<usize> = (0..expected.0.len())
        .filter(|i| expected.1[1 + i] & sight::HIDDEN != 0 && !is_borderline(&scene, *i))
        .collect();
    let hidden = expected.1[1..].iter().filter(|word| **word & sight::HIDDEN != 0).count();
    assert!(sure.len() * 10 > hidden * 9, "{} of {hidden}", sure.len());
    let mut changed = expected.clone();
    changed.1[1 + sure[0]] ^= sight::HIDDEN | sight::SEEN;
    assert!(difference(&scene, &changed, &expected).is_some());
}
