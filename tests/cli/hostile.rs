//! Meshes, skins and clips that no modeller means: each is refused by name, or baked with a warning that counts what was done.

use crate::bench::Bench;
use crowd_pack::Pack;

/// A skinned glTF in the making: one primitive, two joints, one clip that scales the second joint.
#[derive(Clone)]
struct Skinned {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    joints: Vec<[u8; 4]>,
    weights: Vec<[f32; 4]>,
    indices: Vec<u32>,
    /// Scale of the second joint at the clip's end.
    end_scale: f32,
    /// Mode of the primitive.
    mode: u32,
}

/// A ball of 36 triangles, the upper half on the second joint.
fn ball() -> Skinned {
    let mut positions = vec![[0.0, -1.0, 0.0]];
    for row in 1..4 {
        let up = std::f32::consts::PI * row as f32 / 4.0;
        for column in 0..6 {
            let turn = std::f32::consts::TAU * column as f32 / 6.0;
            let radius = libm::sinf(up);
            positions.push([radius * libm::cosf(turn), -libm::cosf(up), radius * libm::sinf(turn)]);
        }
    }
    positions.push([0.0, 1.0, 0.0]);
    let mut indices = Vec::new();
    for column in 0..6 {
        let (a, b) = (1 + column, 1 + (column + 1) % 6);
        indices.extend([0, a, b]);
        for row in 0..2 {
            let (low, high) = (row * 6, row * 6 + 6);
            indices.extend([a + low, a + high, b + high, a + low, b + high, b + low]);
        }
        indices.extend([19, b + 12, a + 12]);
    }
    let upper = |p: &[f32; 3]| if p[1] > 0.1 { [1, 0, 0, 0] } else { [0; 4] };
    Skinned {
        normals: positions.clone(),
        joints: positions.iter().map(upper).collect(),
        weights: vec![[1.0, 0.0, 0.0, 0.0]; positions.len()],
        positions,
        indices,
        end_scale: 2.0,
        mode: 4,
    }
}

impl Skinned {
    /// Writes `NAME.gltf` and `NAME.bin`.
    fn write(&self, bench: &Bench, name: &str) {
        let mut bytes: Vec<u8> = Vec::new();
        let mut views = Vec::new();
        let mut add = |part: Vec<u8>| {
            views.push(format!("{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}", bytes.len(), part.len()));
            bytes.extend(part);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        };
        let floats = |list: &[f32]| list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        add(floats(self.positions.as_flattened()));
        add(floats(self.normals.as_flattened()));
        add(self.joints.as_flattened().to_vec());
        add(floats(self.weights.as_flattened()));
        add(self.indices.iter().flat_map(|i| i.to_le_bytes()).collect());
        add(floats(&[0.0, 1.0]));
        add(floats(&[1.0, 1.0, 1.0, self.end_scale, self.end_scale, self.end_scale]));
        let accessor = |view: usize, component: u32, count: usize, kind: &str| {
            format!("{{\"bufferView\":{view},\"componentType\":{component},\"count\":{count},\"type\":\"{kind}\"}}")
        };
        let count = self.positions.len();
        let accessors = [
            accessor(0, 5126, count, "VEC3"),
            accessor(1, 5126, count, "VEC3"),
            accessor(2, 5121, count, "VEC4"),
            accessor(3, 5126, count, "VEC4"),
            accessor(4, 5125, self.indices.len(), "SCALAR"),
            accessor(5, 5126, 2, "SCALAR"),
            accessor(6, 5126, 2, "VEC3"),
        ];
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],
            "nodes":[{{"mesh":0,"skin":0}},{{"children":[2]}},{{}}],"skins":[{{"joints":[1,2]}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"JOINTS_0":2,"WEIGHTS_0":3}},
            "indices":4,"mode":{}}}]}}],
            "animations":[{{"name":"grow","samplers":[{{"input":5,"output":6}}],
            "channels":[{{"sampler":0,"target":{{"node":2,"path":"scale"}}}}]}}],
            "accessors":[{}],"bufferViews":[{}],"buffers":[{{"uri":"{name}.bin","byteLength":{}}}]}}"#,
            self.mode,
            accessors.join(","),
            views.join(","),
            bytes.len()
        );
        bench.write(&format!("{name}.gltf"), text);
        bench.write(&format!("{name}.bin"), bytes);
    }
}

/// What must come of a case.
enum Answer {
    /// Exit code 0 and these words in the talk; then the pack verifies.
    Baked(&'static [&'static str]),
    /// Exit code 1 and these words.
    Refused(&'static [&'static str]),
}
use Answer::{Baked, Refused};

fn with(change: impl Fn(&mut Skinned)) -> Skinned {
    let mut skinned = ball();
    change(&mut skinned);
    skinned
}

#[test]
fn every_oddity_is_refused_or_counted() {
    let cases: Vec<(&str, Skinned, Answer)> = vec![
        ("plain", ball(), Baked(&["plain: 36 triangles down to"])),
        ("nan_place", with(|s| s.positions[3][1] = f32::NAN), Refused(&["POSITION: vertex 3", "finite"])),
        ("infinite_place", with(|s| s.positions[3][1] = f32::INFINITY), Refused(&["POSITION: vertex 3", "finite"])),
        ("far_place", with(|s| s.positions[3][1] = 1.0e9), Refused(&["vertex 3", "allowed up to"])),
        ("nan_weight", with(|s| s.weights[7][0] = f32::NAN), Refused(&["WEIGHTS_0: vertex 7"])),
        ("nan_normal", with(|s| s.normals[7] = [f32::NAN; 3]), Baked(&["normals-repaired"])),
        ("joint_beyond", with(|s| s.joints[4][0] = 91), Refused(&["vertex 4: joint index 91, skeleton has 2 joints"])),
        ("joint_beyond_unused", with(|s| s.joints[4][3] = 91), Baked(&[])),
        (
            "no_weight",
            with(|s| {
                s.weights[4] = [0.0; 4];
                s.weights[5] = [0.0; 4];
            }),
            Baked(&["weights-missing", "follow their first joint"]),
        ),
        (
            "heavy_weight",
            with(|s| s.weights.iter_mut().for_each(|w| w[0] = 40.0)),
            Baked(&["weights-normalized x", "the sum furthest off is 4"]),
        ),
        ("negative_weight", with(|s| s.weights[4] = [1.0, -1.0, 0.0, 0.0]), Baked(&["weights-negative"])),
        ("index_twice", with(|s| s.indices.extend([3, 3, 4])), Baked(&["degenerate-triangles-dropped"])),
        (
            "two_corners_at_one_place",
            with(|s| {
                s.positions.push(s.positions[3]);
                s.normals.push([0.0, 0.0, 1.0]);
                s.joints.push(s.joints[3]);
                s.weights.push(s.weights[3]);
                s.indices.extend([3, 20, 4]);
            }),
            Baked(&["degenerate-triangles-dropped: mesh: 1 triangles with two corners at one place"]),
        ),
        ("index_left_over", with(|s| s.indices.extend([3, 4])), Baked(&["incomplete-triangles"])),
        (
            "every_triangle_twice",
            with(|s| s.indices.extend(s.indices.clone())),
            Baked(&["duplicate-triangles-dropped: mesh: 36 triangles", "36 triangles down to"]),
        ),
        (
            "a_sheet_on_its_back",
            with(|s| s.indices.extend(s.indices.clone().into_iter().rev())),
            Baked(&["coincident-triangles: mesh: 72 triangles", "non-manifold-edges: mesh: 54 edges"]),
        ),
        (
            "a_page_on_an_edge",
            with(|s| s.indices.extend([1, 2, 19])),
            Baked(&["non-manifold-edges: mesh: 1 edges", "non-manifold-positions: mesh: 3 places"]),
        ),
        (
            "turned_inside_out",
            with(|s| s.indices.chunks_exact_mut(3).for_each(|t| t.swap(0, 1))),
            Baked(&["turned-surfaces", "face away from their own normals"]),
        ),
        (
            "joint_shrinks_to_nothing",
            with(|s| s.end_scale = 0.0),
            Baked(&["joints-vanish", "1 joint without size in 1 of"]),
        ),
        ("joint_turns_inside_out", with(|s| s.end_scale = -1.0), Baked(&[])),
        (
            "joint_grows_out_of_range",
            with(|s| s.end_scale = 1.0e30),
            Refused(&["clip `", "joint `", "allowed up to 1e6"]),
        ),
        ("one_triangle", with(|s| s.indices.truncate(3)), Baked(&["1 triangles down to 1"])),
        ("no_triangle", with(|s| s.indices.truncate(2)), Refused(&["at least one triangle"])),
        ("one_place", with(|s| s.positions.fill([1.0; 3])), Refused(&["degenerate"])),
        ("a_line", with(|s| (0..20_u8).for_each(|v| s.positions[v as usize] = [f32::from(v), 0.0, 0.0])), Baked(&[])),
        ("points", with(|s| s.mode = 0), Refused(&["at least one triangle"])),
    ];
    let mut wrong = Vec::new();
    for (name, skinned, answer) in cases {
        let bench = Bench::new();
        skinned.write(&bench, name);
        let done = bench.run(&["bake", &format!("@{name}.gltf"), "-o", "@out.crowdpack"]);
        let (code, words) = match answer {
            Baked(words) => (0, words),
            Refused(words) => (1, words),
        };
        if done.code != code || words.iter().any(|word| !done.err.contains(word)) {
            wrong.push(format!("{name}: expected {code} and {words:?}, found {}:\n{}", done.code, done.err));
        } else if code == 0 {
            let verified = bench.run(&["verify", "@out.crowdpack"]);
            if verified.code != 0 {
                wrong.push(format!("{name} does not verify:\n{}{}", verified.out, verified.err));
            }
        } else {
            assert!(!bench.path("out.crowdpack").exists(), "{name}");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn strict_refuses_what_is_repaired_and_nothing_else() {
    let cases: Vec<(&str, Skinned, &[&str])> = vec![
        ("heavy_weight", with(|s| s.weights[3][0] = 40.0), &["load: 1 warning with --strict", "weights-normalized"]),
        (
            "every_triangle_twice",
            with(|s| s.indices.extend(s.indices.clone())),
            &["simplify: 1 warning with --strict", "duplicate-triangles-dropped"],
        ),
    ];
    for (name, skinned, words) in cases {
        let bench = Bench::new();
        skinned.write(&bench, name);
        let done = bench.run(&["bake", &format!("@{name}.gltf"), "-o", "@out.crowdpack", "--strict"]);
        done.expect(1).says(words);
        assert!(!bench.path("out.crowdpack").exists());
    }
    // A page on an edge is odd, but it stays as it is.
    let bench = Bench::new();
    with(|s| s.indices.extend([1, 2, 19])).write(&bench, "odd");
    bench.run(&["bake", "@odd.gltf", "-o", "@out.crowdpack", "--strict"]).expect(0);
}

#[test]
fn more_vertices_than_sixteen_bits_count_make_a_pack_and_a_glb() {
    let bench = Bench::new();
    let (columns, rows) = (280, 240);
    let mut text = String::new();
    for row in 0..rows {
        for column in 0..columns {
            let (x, y) = (column as f32 / columns as f32, row as f32 / rows as f32);
            text += &format!("v {x} {y} {}\n", 0.1 * libm::sinf(9.0 * x) * libm::cosf(7.0 * y));
        }
    }
    for row in 1..rows {
        for column in 1..columns {
            let a = (row - 1) * columns + column;
            text += &format!("f {a} {} {} {}\n", a + 1, a + 1 + columns, a + columns);
        }
    }
    bench.write("field.obj", text);
    bench.run(&["bake", "@field.obj", "-o", "@out.crowdpack"]).expect(0);
    let pack = Pack::open(&bench.path("out.crowdpack")).expect("the pack is whole");
    assert!(pack.contents().vertices.len() > 1 << 16, "{}", pack.contents().vertices.len());
    bench.run(&["export", "@out.crowdpack", "--ratio", "1", "-o", "@full.glb"]).expect(0);
    bench.run(&["inspect", "@full.glb"]).expect(0);
}

#[test]
fn numbers_that_no_pack_holds_cost_their_own_character_alone() {
    let bench = Bench::new();
    let quad = |scale: &str, vt: &str| {
        format!(
            "v 0 0 0\nv 1{scale} 0 0\nv 1{scale} 1{scale} 0\nv 0 1{scale} 0\nvt {vt} 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
        )
    };
    bench.write("good.obj", quad("", "0"));
    bench.write("speck.obj", quad("e-38", "0"));
    bench.write("far_texture.obj", quad("", "1e20"));
    bench.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 1 1e-40 1\nv 0 1e-40 1\nf 1 2 3 4\n");
    let done = bench.run(&["bake", "@good.obj", "@speck.obj", "@far_texture.obj", "@flat.obj", "-o", "@out.crowdpack"]);
    done.expect(1).says(&["speck: ", "far_texture: uvs-repaired", "became 0, 0"]);
    let pack = Pack::open(&bench.path("out.crowdpack")).expect("the pack is whole");
    let names: Vec<&str> = pack.contents().manifest.characters.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["good", "far_texture", "flat"]);
    bench.run(&["verify", "@out.crowdpack"]).expect(0);
}

#[test]
fn clips_that_all_count_nothing_are_refused_by_the_option() {
    let bench = Bench::new();
    ball().write(&bench, "ball");
    let done = bench.run(&["bake", "@ball.gltf", "-o", "@out.crowdpack", "--clip-weight", "grow=0"]);
    done.expect(1).says(&["all clips have the weight 0", "--clip-weight"]);
}

#[cfg(unix)]
#[test]
fn pipes_that_nobody_writes_to_are_refused() {
    let bench = Bench::new();
    let made =
        std::process::Command::new("mkfifo").arg(bench.path("pipe.glb")).arg(bench.path("pipe.crowdpack")).status();
    if !made.is_ok_and(|status| status.success()) {
        eprintln!("ignored: no mkfifo here");
        return;
    }
    for words in [["inspect", "@pipe.glb"], ["inspect", "@pipe.crowdpack"], ["verify", "@pipe.crowdpack"]] {
        bench.run(&words).expect(1).says(&["plain file"]);
    }
}
