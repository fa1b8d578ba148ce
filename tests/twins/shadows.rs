//! Shadows in pictures: where they fall, where they do not, and with whom.

use crate::cases::data;
use crate::occlusion::{HEIGHT, ON, WIDTH, renderer as street_renderer, street};
use crate::whole_chain::{OPTIONS, apart, compare, draw, is_rounding, one_clip_each, renderer};
use crowd_stages::gpu::CrowdRenderer;
use crowd_stages::{
    DrawOptions, DrawnInstance, FrameConfig, FrameView, InstanceRecord, SUN_DIRECTION, Skinning, Technique, Weight,
};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic;
use glam::{Mat4, Vec3};

const SHADED: DrawOptions = DrawOptions { technique: Technique::Bucketed, shadows: 4, occlusion: false, ..ON };
const PLAIN: DrawOptions = DrawOptions { shadows: 0, ..SHADED };

fn view(eye: Vec3, target: Vec3, fov_y_rad: f32) -> FrameView {
    let camera = glam::camera::rh::view::look_at_mat4(eye, target, Vec3::Y);
    let projection = glam::camera::rh::proj::directx::perspective(fov_y_rad, 16.0 / 9.0, 0.5, 1000.0);
    let clip_from_world = projection * camera;
    FrameView { clip_from_world, fov_y_rad, ..synthetic::view(eye, target, u32::MAX, Weight::Area, HEIGHT) }
}

/// Somebody stout on an empty place.
fn somebody() -> Vec<InstanceRecord> {
    vec![InstanceRecord { scale: 1.0, character: 1, clip: data().characters[1].clip_offset, ..Default::default() }]
}

/// Pictures with and without shadows.
fn pictures(instances: &[InstanceRecord], view: &FrameView, technique: Technique) -> [Vec<[u8; 4]>; 2] {
    let mut renderer = renderer(OPTIONS, instances);
    let picture = Picture::new((WIDTH, HEIGHT));
    let config = FrameConfig::from_camera(view);
    [SHADED, PLAIN].map(|options| {
        draw(&mut renderer, &picture, &config, DrawOptions { technique, ..options });
        picture.pixels()
    })
}

fn brightness(pixel: [u8; 4]) -> i32 {
    pixel.iter().take(3).map(|value| i32::from(*value)).sum()
}

/// The pixel at which a place is seen.
fn pixel_of(view: &FrameView, p: Vec3) -> usize {
    let at = view.clip_from_world.project_point3(p);
    let (x, y) = ((at.x * 0.5 + 0.5) * WIDTH as f32, (0.5 - at.y * 0.5) * HEIGHT as f32);
    y as usize * WIDTH as usize + x as usize
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_shadow_falls_away_from_the_sun_begins_at_the_feet_and_nothing_gets_brighter() {
    let view = view(Vec3::new(-1.0, 9.0, 7.0), Vec3::new(-0.5, 0.0, -0.5), 0.6);
    for technique in [Technique::Bucketed, Technique::PseudoInstancing, Technique::Reform] {
        let [shaded, plain] = pictures(&somebody(), &view, technique);
        let sun = Vec3::from(SUN_DIRECTION);
        let away = -Vec3::new(sun.x, 0.0, sun.z) / sun.y;
        let darker = |p: Vec3| brightness(plain[pixel_of(&view, p)]) - brightness(shaded[pixel_of(&view, p)]);
        for height_m in [0.5, 0.8, 1.1] {
            assert!(darker(away * height_m) > 60, "{technique}: {} at {height_m} m", darker(away * height_m));
        }
        for p in [-away, away * 3.5, away * 0.8 + Vec3::new(1.5, 0.0, -1.2), away * 0.8 - Vec3::new(1.5, 0.0, -1.2)] {
            assert_eq!(darker(p), 0, "{technique}: {p}");
        }
        assert!(shaded.iter().zip(&plain).all(|(a, b)| brightness(*a) <= brightness(*b) + 1), "{technique}");
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn who_looks_with_the_sun_sees_no_shadow_at_all() {
    let sun = Vec3::from(SUN_DIRECTION);
    let instances = synthetic::instances(data(), 25);
    let share = |eye: Vec3, fov: f32| {
        let [shaded, plain] = pictures(&instances, &view(eye, Vec3::new(0.0, 0.5, 0.0), fov), Technique::Bucketed);
        let apart = |(a, b): &(&[u8; 4], &[u8; 4])| brightness(**b) - brightness(**a) > 12;
        shaded.iter().zip(&plain).filter(apart).count() as f32 / plain.len() as f32
    };
    // Acne would be everywhere; at outlines the sun and the eye differ, for the eye is near.
    let with_the_sun = share(sun * 80.0, 0.14);
    let aside = share(Vec3::new(-sun.z, sun.y, sun.x) * 80.0, 0.14);
    println!("{with_the_sun} of the picture in shadow seen from the sun, {aside} from aside");
    assert!(with_the_sun < 0.02 && aside > 3.0 * with_the_sun, "{with_the_sun} from the sun, {aside} from aside");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn hidden_people_throw_their_shadows_all_the_same() {
    let street = street();
    let mut renderer = street_renderer(1);
    renderer.set_instances(&gpu::device().1, &street.instances).expect("valid");
    let picture = Picture::new((WIDTH, HEIGHT));
    for frame in [0, 1, 6] {
        let config = street.config(frame);
        draw(&mut renderer, &picture, &config, DrawOptions { shadows: 3, occlusion: false, ..ON });
        let without = picture.pixels();
        let totals = draw(&mut renderer, &picture, &config, DrawOptions { shadows: 3, ..ON });
        let different = picture.pixels().iter().zip(&without).filter(|(a, b)| a != b).count();
        assert_eq!(different, 0, "frame {frame}, {} occluded", totals.occluded_count);
    }
    let config = street.config(6);
    draw(&mut renderer, &picture, &config, ON);
    let plain = picture.pixels();
    draw(&mut renderer, &picture, &config, DrawOptions { shadows: 3, ..ON });
    assert!(picture.pixels() != plain, "shadows show");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn dots_throw_as_much_shadow_as_meshes() {
    let instances = synthetic::instances(data(), 400);
    // Their coarse levels have hardly any outline left: let them cast at full detail.
    let mut data = data().clone();
    data.levels.iter_mut().for_each(|level| level.bound_m = 1e6);
    let view = view(Vec3::new(-20.0, 60.0, 130.0), Vec3::ZERO, 0.5);
    let (device, queue) = gpu::device();
    let mut renderer = CrowdRenderer::new(device, queue, &data, OPTIONS).expect("it fits");
    renderer.set_instances(queue, &instances).expect("valid");
    let picture = Picture::new((WIDTH, HEIGHT));
    let mut shade_of = |dot_area_px2: f32| {
        let config = FrameConfig { dot_area_px2, ..FrameConfig::from_camera(&view) };
        let [shaded, plain] = [SHADED, PLAIN].map(|options| {
            draw(&mut renderer, &picture, &config, options);
            picture.pixels()
        });
        plain.iter().zip(&shaded).map(|(a, b)| i64::from(brightness(*a) - brightness(*b)).max(0)).sum::<i64>()
    };
    // Full detail for the camera in both, for the budget has no end.
    let [meshes, dots] = [0.0, 200.0].map(&mut shade_of);
    assert!(meshes > 0 && dots != meshes, "somebody is dots for the sun");
    assert!((0.7..1.4).contains(&(dots as f32 / meshes as f32)), "{meshes} of meshes, {dots} of dots");
}

/// Vertices that the crowd's own pass has skinned serve the maps, too; who is not in that pass skins its own.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn casters_with_vertices_of_the_crowds_own_pass_throw_the_same_shadows() {
    let mut instances = synthetic::instances(data(), 300);
    let view = view(Vec3::new(3.0, 4.0, 14.0), Vec3::ZERO, 0.5);
    let picture = Picture::new((WIDTH, HEIGHT));
    let way = |skinning| DrawOptions { skinning, ..SHADED };
    // Some fade; all are shown between levels.
    instances.iter_mut().step_by(3).for_each(|i| (i.leaving_clip, i.leaving_share) = (i.clip, 0.4));
    let mut renderer = renderer(OPTIONS, &instances);
    for fade in [true, false] {
        if !fade {
            renderer.set_instances(&gpu::device().1, &one_clip_each(&instances)).expect("they were good");
        }
        for (budget, no_morph, occlusion, dot_area_px2) in [
            (9000, false, false, 0.0),
            (9000, true, false, 0.0),
            (20_000, false, true, 60.0),
            (u32::MAX, false, false, 0.0),
        ] {
            let config = FrameConfig { budget, dot_area_px2, ..FrameConfig::from_camera(&view) };
            let mut of = |options: DrawOptions| {
                let totals = draw(&mut renderer, &picture, &config, options);
                (picture.pixels(), totals)
            };
            let [vertex, compute] = [Skinning::Vertex, Skinning::Compute]
                .map(|skinning| of(DrawOptions { no_morph, occlusion, ..way(skinning) }));
            let plain = of(DrawOptions { shadows: 0, no_morph, occlusion, ..way(Skinning::Vertex) }).0;
            assert_eq!(vertex.1, compute.1);
            let difference = compare(&vertex.0, &compute.0);
            let what = format!(
                "N = {budget}, no_morph {no_morph}, occlusion {occlusion}, fade {fade}: {}",
                apart(&difference)
            );
            println!("{what}");
            assert!(if fade { is_rounding(&difference) } else { difference.max == 0 }, "{what}");
            assert!(vertex.0.iter().zip(&plain).filter(|(a, b)| a != b).count() > 1000, "shadows are seen");
        }
    }
    // Room for others: who lent is set up anew.
    let config = FrameConfig { budget: 9000, ..FrameConfig::from_camera(&view) };
    draw(&mut renderer, &picture, &config, way(Skinning::Compute));
    let before = picture.pixels();
    renderer.make_room(OPTIONS.max_vertices / 2, OPTIONS.max_triangles / 2);
    draw(&mut renderer, &picture, &config, way(Skinning::Vertex));
    assert!(picture.pixels() == before, "nobody lends");
    draw(&mut renderer, &picture, &config, way(Skinning::Compute));
    assert!(picture.pixels() == before, "somebody else lends");
    // Both kinds were there: who borrows, and who is not seen and skins its own.
    let read = |name| renderer.buffer(Technique::Bucketed, name).expect("a map was drawn").clone();
    let keys: Vec<u32> = gpu::read(&read("casters"), instances.len());
    let casters: Vec<DrawnInstance> = gpu::read(&read("drawn_casters"), instances.len());
    let meshes = crate::cases::buckets().mesh_count;
    let alone = |c: &DrawnInstance| c.vertex_base == crowd_pack::NONE;
    let of_last: Vec<bool> = casters.iter().zip(&keys).filter(|(_, k)| **k < meshes).map(|(c, _)| alone(c)).collect();
    let by_themselves = of_last.iter().filter(|alone| **alone).count();
    println!("{by_themselves} of {} casters skin their own vertices", of_last.len());
    assert!(by_themselves > 0 && by_themselves < of_last.len(), "{by_themselves} of {}", of_last.len());
}

/// Ways differ where somebody fades, in the picture or in the maps: which one `auto` takes must not depend on the clock.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn two_runs_of_auto_with_fades_and_four_maps_give_the_same_pixels_in_every_frame() {
    let instances = synthetic::instances(data(), 300);
    assert!(instances.iter().filter(|one| one.leaving_share > 0.1).count() > 100);
    let view = view(Vec3::new(3.0, 4.0, 14.0), Vec3::ZERO, 0.5);
    let picture = Picture::new((WIDTH, HEIGHT));
    let run = || {
        let mut renderer = renderer(OPTIONS, &instances);
        let frame = |number: u32| {
            let config = FrameConfig { budget: 9000, ..FrameConfig::from_camera(&view) };
            let config = FrameConfig { time_s: config.time_s + 0.04 * number as f32, ..config };
            draw(&mut renderer, &picture, &config, DrawOptions { skinning: Skinning::Auto, ..SHADED });
            picture.pixels()
        };
        // More than a trial of three ways takes.
        (0..16).map(frame).collect::<Vec<_>>()
    };
    let (first, second) = (run(), run());
    for (number, (a, b)) in first.iter().zip(&second).enumerate() {
        assert!(a == b, "frame {number}: {}", apart(&compare(a, b)));
    }
    assert!(first[0] != first[1], "people move");
}

#[test]
fn a_place_is_seen_at_its_pixel() {
    let view = view(Vec3::new(0.0, 5.0, 5.0), Vec3::ZERO, 0.6);
    assert_eq!(pixel_of(&view, Vec3::ZERO), (HEIGHT / 2 * WIDTH + WIDTH / 2) as usize);
    assert_eq!(Mat4::IDENTITY.project_point3(Vec3::X), Vec3::X);
}
