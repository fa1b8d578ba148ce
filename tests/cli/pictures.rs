//! `picture`: the strip has the size asked for and something on it.

use crate::bench::{Bench, TUBE};

fn decode(bytes: &[u8]) -> image::RgbaImage {
    image::load_from_memory(bytes).expect("a PNG").to_rgba8()
}

#[test]
fn every_paint_draws_a_column_a_level_and_a_row_a_pose() {
    let bench = Bench::with(&[TUBE]);
    bench.run(&["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack"]).expect(0);
    let clip =
        bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json()["characters"][0]["clips"][0]["name"]
            .as_str()
            .expect("the tube bends")
            .to_owned();
    for paint in ["shaded", "classes", "wireframe", "error"] {
        let words = [
            "picture",
            "@out.crowdpack",
            "-o",
            "@p.png",
            "--paint",
            paint,
            "--size",
            "96x128",
            "--ratios",
            "1,0.2,0.05",
            "--clip",
            "bind",
            "--clip",
            &clip,
        ];
        bench.run(&words).expect(0);
        let picture = decode(&bench.read("p.png"));
        assert_eq!(picture.dimensions(), (3 * 96, 2 * 128), "{paint}");
        for cell in 0..6 {
            let (left, top) = (cell % 3 * 96, cell / 3 * 128);
            let background = picture.get_pixel(left, top);
            let inside = (20..76).flat_map(|x| (30..100).map(move |y| (x, y)));
            let drawn = inside.filter(|&(x, y)| picture.get_pixel(left + x, top + y) != background).count();
            assert!(drawn > 300, "{paint}, cell {cell}: {drawn} pixels");
        }
    }
}

#[test]
fn an_asset_is_baked_on_the_way_and_an_unknown_clip_is_refused() {
    let bench = Bench::with(&[TUBE]);
    let input = format!("@{TUBE}");
    bench.run(&["picture", &input, "-o", "@p.png", "--size", "64x64"]).expect(0);
    let done = bench.run(&["picture", &input, "-o", "@q.png", "--clip", "Swim"]).expect(1);
    done.says(&["no clip of that name; the character has bend"]);
    assert!(!bench.path("q.png").exists());
}

#[test]
fn a_picture_of_too_many_pixels_is_refused_before_anything_is_opened() {
    let bench = Bench::new();
    let ratios = ["1"; 5].join(",");
    let words = ["picture", "@gone.glb", "-o", "@p.png", "--size", "4096x4096", "--ratios", &ratios];
    bench.run(&words).expect(2).says(&["found 83886080 pixels, allowed 67108864"]);
    assert!(bench.listing().is_empty());
}
