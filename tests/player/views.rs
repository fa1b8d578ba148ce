//! What a picture shows besides people as they look: views, the reference camera.

use crate::Scene;
use image::{Rgb, RgbImage};

const CROWD: [&str; 8] = ["--count", "300", "--size", "384x216", "--backend", "gpu", "--eye=0,2,4", "--target=0,1,-8"];

fn picture(scene: &Scene, words: &[&str]) -> RgbImage {
    scene.picture(&[&CROWD[..], words].concat())
}

fn count(picture: &RgbImage, is_one: impl Fn(&Rgb<u8>) -> bool) -> usize {
    picture.pixels().filter(|pixel| is_one(pixel)).count()
}

fn differ(a: &RgbImage, b: &RgbImage) -> usize {
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1")]
#[test]
fn each_view_shows_something_else() {
    let scene = Scene::new();
    let few = ["--technique", "reform", "--budget", "15000", "--view"];
    let shaded = picture(&scene, &few[..4]);
    assert!(shaded == picture(&scene, &[&few[..], &["shaded"]].concat()));
    let views = ["levels", "density", "representation"].map(|view| picture(&scene, &[&few[..], &[view]].concat()));
    for (i, view) in views.iter().enumerate() {
        assert!(differ(view, &shaded) > 1000, "{}", differ(view, &shaded));
        assert!(views[..i].iter().all(|other| differ(view, other) > 200));
    }
    // With room for all everyone is at full detail: red alone.
    let reddish = |p: &Rgb<u8>| p.0[0] > p.0[1].saturating_add(40) && p.0[0] > p.0[2].saturating_add(40);
    let greenish = |p: &Rgb<u8>| p.0[1] > p.0[0].saturating_add(25) && p.0[1] > p.0[2].saturating_add(25);
    let full = picture(&scene, &["--view", "representation", "--budget", "100000000"]);
    assert!(count(&full, reddish) > count(&shaded, reddish) + 1000, "{}", count(&full, reddish));
    let hidden = picture(&scene, &["--view", "occlusion", "--occlusion", "on"]);
    assert!(count(&hidden, greenish) > 1000 && count(&shaded, greenish) < 400, "{}", count(&hidden, greenish));
}

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1")]
#[test]
fn the_reference_camera_shows_the_culled_in_the_corner_and_changes_nothing_else() {
    let scene = Scene::new();
    for technique in ["bucketed", "reform", "instanced", "points"] {
        let plain = picture(&scene, &["--technique", technique]);
        let with = picture(&scene, &["--technique", technique, "--reference-camera"]);
        let is_corner = |x: u32, y: u32| x >= 384 * 2 / 3 - 12 && y >= 216 * 2 / 3 - 12;
        let outside =
            plain.enumerate_pixels().filter(|(x, y, pixel)| !is_corner(*x, *y) && *pixel != with.get_pixel(*x, *y));
        assert_eq!(outside.count(), 0, "{technique}");
        // Edges are red and dots are yellow, thinned by the means of nine pixels.
        let edge = |p: [u8; 3]| p[0] > p[1].saturating_add(50) && p[1].abs_diff(p[2]) < 20;
        let dot = |p: [u8; 3]| p[0] >= p[1] && p[0] - p[1] < 40 && p[1] > p[2].saturating_add(25);
        let corner = |is_one: &dyn Fn([u8; 3]) -> bool| {
            with.enumerate_pixels().filter(|(x, y, pixel)| is_corner(*x, *y) && is_one(pixel.0)).count()
        };
        assert!(corner(&edge) > 20 && corner(&dot) > 30, "{technique}: {} and {}", corner(&edge), corner(&dot));
    }
    // Of a simulator's instances, too.
    let flock = ["--flock", "300", "--simulate", "gpu", "--size", "384x216", "--eye=0,2,4", "--target=0,1,-8"];
    let plain = scene.picture(&flock);
    assert!(differ(&plain, &scene.picture(&[&flock[..], &["--reference-camera"]].concat())) > 2000);
}
