//! Vertices that share too few joints with where they come from: those of the shared crowd have two joints of three, so that one list always
//! has room for both.

use crate::cases::{self, Case};
use crate::skin_vertices::{compared_with_whole_poses, fed_in, first_apart, way};
use crate::whole_chain::{OPTIONS, apart, close_up, compare, draw, is_rounding, one_clip_each, renderer_of};
use crowd_pack::{VertexRecord, store_frame, stored_frames};
use crowd_stages::{Buckets, CrowdData, FrameConfig, OriginRecord, Skinning, Weight};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic::{self, hash};
use glam::Vec4;
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// Joints of every barrel here: those of the shared one, and three more beside each, a little ahead of it in time.
const JOINTS: u32 = 12;

/// The shared crowd on these joints, up to four a vertex in all sorts of places.
fn crowded() -> &'static CrowdData {
    static DATA: OnceLock<CrowdData> = OnceLock::new();
    DATA.get_or_init(|| {
        let mut data = cases::data().clone();
        for (v, vertex) in (0..).zip(&mut data.vertices) {
            (vertex.joints, vertex.weights) = influences(v, halves(vertex.joints), halves(vertex.weights));
        }
        let before = std::mem::take(&mut data.animation);
        for character in &mut data.characters {
            let storage = character.storage().expect("barrels have one");
            let clips = character.clip_offset as usize..(character.clip_offset + character.clip_count) as usize;
            for clip in &mut data.clips[clips] {
                let old = stored_frames(storage, &before[clip.texel_offset as usize..], character.joint_count);
                let old: Vec<_> = old.chunks(character.joint_count as usize).take(clip.frame_count as usize).collect();
                clip.texel_offset = data.animation.len() as u32;
                for frame in 0..old.len() {
                    // The last frame is the first one's pose.
                    let [now, next] = [frame, frame + 1].map(|frame| old[frame % (old.len() - 1)]);
                    let ahead = |j: u32| {
                        let (joint, share) = ((j % 3) as usize, (j / 3) as f32 * 0.2);
                        let row = |r: usize| Vec4::from(now[joint][r]).lerp(next[joint][r].into(), share).to_array();
                        [0, 1, 2].map(row)
                    };
                    store_frame(storage, &(0..JOINTS).map(ahead).collect::<Vec<_>>(), &mut data.animation);
                }
                // Joints that are not rigid and ahead.
                clip.sphere[3] *= 1.5;
            }
            character.joint_count = JOINTS;
        }
        data
    })
}

/// The two joints of a vertex each split into two that stand beside it; no weight on the first place or within, one joint twice, fewer
/// than four.
fn influences(v: u32, joints: [u32; 4], weights: [u32; 4]) -> ([u32; 2], [u32; 2]) {
    let beside = |joint: u32, salt: u32| {
        let first = hash(v * 4 + salt) % 4;
        [joint + 3 * first, joint + 3 * ((first + 1 + hash(v * 4 + salt + 1) % 3) % 4)]
    };
    let ([a, b], [c, d]) = (beside(joints[0], 0), beside(joints[1], 1));
    let [low, high] = [weights[0], weights[1]];
    let (joints, weights) = match hash(v * 4 + 3) % 8 {
        0 => ([b, a, c, d], [0, low, high / 3, high - high / 3]),
        1 => ([a, 0, c, d], [low, 0, high / 3, high - high / 3]),
        2 => ([a, c, a, d], [low / 3, high / 3, low - low / 3, high - high / 3]),
        3 => ([a, c, 0, 0], [low, high, 0, 0]),
        4 => ([d, a, 0, c], [0, low, 0, high]),
        _ => ([c, a, b, d], [high / 3, low / 3, low - low / 3, high - high / 3]),
    };
    let words = |halves: [u32; 4]| [halves[0] | halves[1] << 16, halves[2] | halves[3] << 16];
    (words(joints), words(weights))
}

fn crowded_buckets() -> &'static Buckets {
    static BUCKETS: OnceLock<Buckets> = OnceLock::new();
    BUCKETS.get_or_init(|| Buckets::of(crowded()).expect("as many levels as before"))
}

fn case(count: u32) -> Case {
    let instances = synthetic::instances(crowded(), count);
    Case { data: crowded(), instances, config: synthetic::config(count, count * 30, Weight::Area) }
}

fn is_beside(vertex: &VertexRecord, origin: &OriginRecord) -> bool {
    vertex.joints[0] & 0xffff == origin.joints[0] & 0xffff
}

fn halves(words: [u32; 2]) -> [u32; 4] {
    [words[0] & 0xffff, words[0] >> 16, words[1] & 0xffff, words[1] >> 16]
}

/// A joint of the vertex that does not stand at its own place in a list that the shader walks once for both.
fn misplaced(vertices: &[VertexRecord], origins: &[OriginRecord]) -> Option<String> {
    let is_wrong = |(vertex, origin): &(&VertexRecord, &OriginRecord)| {
        let places = halves(vertex.joints).into_iter().zip(halves(vertex.weights)).zip(halves(origin.joints));
        let moved = |((own, weight), there): ((u32, u32), u32)| weight > 0 && own != there;
        is_beside(vertex, origin) && places.into_iter().any(moved)
    };
    let v = vertices.iter().zip(origins).position(|pair| is_wrong(&pair))?;
    Some(format!("vertex {v}: {:?}, comes from {:?}", vertices[v], origins[v]))
}

#[test]
fn one_walk_over_the_joints_finds_every_joint_of_the_vertex_at_its_own_place() {
    let [shared, crowded] =
        [(cases::data(), cases::buckets()), (crowded(), crowded_buckets())].map(|(data, buckets)| {
            let origins = buckets.origins(data);
            assert_eq!(misplaced(&data.vertices, &origins), None);
            let pairs = data.vertices.iter().zip(&origins);
            let moved = pairs.filter(|(vertex, origin)| vertex.position != origin.position);
            let (one_walk, two_walks): (Vec<_>, Vec<_>) = moved.partition(|(vertex, origin)| is_beside(vertex, origin));
            (one_walk.len(), two_walks.len())
        });
    println!("one walk and two: {shared:?} of the shared crowd, {crowded:?} of the crowded one");
    assert_eq!(shared.1, 0, "the shared crowd never asks for two walks");
    assert!(crowded.0 > 100 && crowded.1 > 100, "{crowded:?}");

    // The comparison can fail: joints in another order, which begin alike.
    let data = cases::data();
    let mut turned = cases::buckets().origins(data);
    for origin in &mut turned {
        origin.joints = [origin.joints[0] & 0xffff | origin.joints[1] << 16, origin.joints[0] >> 16];
    }
    assert!(misplaced(&data.vertices, &turned).is_some());
}

/// Vertices of drawn people on their way from an origin whose joints are walked after their own; and of those, of people who fade.
fn count_two_walks(fed: &crate::skin_vertices::Fed) -> [usize; 2] {
    let mut counts = [0; 2];
    for (range, place) in fed.sorted.ranges.iter().zip(&fed.sorted.places).take(crowded_buckets().mesh_count as usize) {
        let mesh = place.vertex_offset as usize..(place.vertex_offset + place.vertex_count) as usize;
        for one in &fed.drawn[range.first as usize..range.end as usize] {
            let pairs = crowded().vertices[mesh.clone()].iter().zip(&fed.origins[mesh.clone()]);
            let moves = |origin: &OriginRecord| origin.vertex >= one.coarser_vertex_count && one.fraction < 1.0;
            let two = pairs.filter(|(vertex, origin)| moves(origin) && !is_beside(vertex, origin)).count();
            counts[0] += two;
            counts[1] += if one.leaving_share > 0.1 { two } else { 0 };
        }
    }
    counts
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn vertices_that_are_walked_after_one_another_agree() {
    for count in [200, 1000] {
        let case = case(count);
        let mut fed = fed_in(crowded_buckets(), &case, u32::MAX);
        let [two_walks, of_fading] = count_two_walks(&fed);
        println!("{count} instances: {two_walks} vertices take two walks, {of_fading} of people who fade");
        assert!(two_walks > 200 && of_fading > 50, "{two_walks}, {of_fading} of people who fade");
        let (gpu, cpu) = (fed.on_gpu(), fed.on_cpu());
        assert!(gpu.len() == cpu.len() && !gpu.is_empty());
        assert_eq!(first_apart(&gpu, &cpu), None, "{count} instances");
        let (compared, fading) = compared_with_whole_poses(&case, &fed, &gpu);
        assert!(compared == gpu.len() && fading > 100, "{compared} of {}, {fading} fade", gpu.len());

        // The comparison can fail: origins that are walked as if they stood beside their vertices.
        for (origin, vertex) in fed.origins.iter_mut().zip(&crowded().vertices) {
            origin.joints = vertex.joints;
        }
        assert!(first_apart(&fed.on_gpu(), &cpu).is_some());
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn all_ways_to_skin_them_give_the_same_picture() {
    let (fading, config) = close_up();
    let config = FrameConfig { budget: 6000, ..config };
    let mut renderer = renderer_of(crowded(), OPTIONS, &fading);
    let picture = Picture::new((640, 360));
    for (instances, fade) in [(one_clip_each(&fading), false), (fading, true)] {
        renderer.set_instances(&gpu::device().1, &instances).expect("they were good");
        let totals = draw(&mut renderer, &picture, &config, way(Skinning::Vertex, false));
        let of_vertex_shader = picture.pixels();
        assert!(of_vertex_shader.iter().collect::<BTreeSet<_>>().len() > 1000, "this is a picture");
        let [palettes, compute] = [Skinning::Palettes, Skinning::Compute].map(|skinning| {
            assert_eq!(draw(&mut renderer, &picture, &config, way(skinning, false)), totals);
            assert_eq!(renderer.skinning(skinning).way, skinning);
            picture.pixels()
        });
        let difference = compare(&compute, &of_vertex_shader);
        let what = format!("fade {fade}: {}", apart(&difference));
        println!("{what}");
        assert!(if fade { is_rounding(&difference) } else { difference.max == 0 }, "{what}");
        assert!(palettes == compute, "fade {fade}: both have palettes");
        draw(&mut renderer, &picture, &config, way(Skinning::Vertex, true));
        assert!(compare(&picture.pixels(), &of_vertex_shader).share_over(8) > 0.005, "morphs are seen");
    }
}
