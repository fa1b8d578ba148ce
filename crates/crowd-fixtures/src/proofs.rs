//! Small meshes that each prove one thing, named after it.

use glam::{Vec2, Vec3, vec2, vec3};
use image::ExtendedColorType;

use crate::Fixture;
use crate::assemble::png;
use crate::glb::{Clip, Curve, Document, Material, Node, Primitive};
use crate::motion::turn;
use crate::profile::smoothstep;

const TAU: f32 = core::f32::consts::TAU;

/// All proofs.
pub fn proofs() -> Vec<Fixture> {
    let glb = |name: &str, d: Document| Fixture { path: format!("good/{name}.glb"), bytes: d.to_glb() };
    let mut out = vec![
        glb("straight_tube_should_keep_its_elbow", tube(false)),
        glb("flat_sided_tube_should_lose_its_elbow_in_bind_pose_only", tube(true)),
        glb("sphere_with_seam_and_poles", sphere()),
        glb("cube_with_cuts_should_keep_8_fixed", cube()),
        glb("two_materials_should_keep_their_border", two_materials()),
        glb("rigid_hat_should_follow_the_head_joint", hat()),
        glb("two_slits_should_have_20_companions_and_regular_ends", two_seams()),
        glb("smallest_character_should_stay_one_triangle", triangle()),
    ];
    out.extend(crate_obj());
    out
}

/// A chequered picture of `size` texels whose squares have different tints, so that a shift shows.
pub fn chequered(size: u32, a: [u8; 3], b: [u8; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for y in 0..size {
        for x in 0..size {
            let (i, j) = (x * 8 / size, y * 8 / size);
            let base = if (i + j) % 2 == 0 { a } else { b };
            let fine = x % (size / 8) == 0 || y % (size / 8) == 0;
            let tint = [i * 4, (7 - i) * 3, j * 4];
            bytes.extend((0..3).map(|k| {
                let c = base[k].saturating_sub(tint[k] as u8);
                if fine { c / 2 } else { c }
            }));
        }
    }
    png(&bytes, size, ExtendedColorType::Rgb8)
}

fn painted(name: &str, image: Option<usize>, colour: [f32; 4]) -> Material {
    Material { name: name.into(), colour, image, double_sided: false }
}

/// Adds a grid of (columns + 1) x (rows + 1) wedges; `at(u, v)` gives position and normal.
fn add_grid(
    p: &mut Primitive,
    columns: usize,
    rows: usize,
    at: &dyn Fn(f32, f32) -> (Vec3, Vec3),
    uv: &dyn Fn(f32, f32) -> Vec2,
) {
    let first = p.positions.len() as u32;
    for j in 0..=rows {
        for i in 0..=columns {
            let (u, v) = (i as f32 / columns as f32, j as f32 / rows as f32);
            let (position, normal) = at(u, v);
            // Adding zero turns -0 into 0.
            p.positions.push((position + Vec3::ZERO).to_array());
            p.normals.push(normal.to_array());
            p.uvs.push(uv(u, v).to_array());
        }
    }
    let w = columns as u32 + 1;
    for j in 0..rows as u32 {
        for i in 0..columns as u32 {
            let a = first + j * w + i;
            for t in [[a, a + 1, a + w + 1], [a, a + w + 1, a + w]] {
                // A pole's quads are triangles.
                let q = t.map(|k| Vec3::from(p.positions[k as usize]));
                if (q[1] - q[0]).cross(q[2] - q[0]).length() > 1e-9 {
                    p.indices.extend(t);
                }
            }
        }
    }
    drop_unused(p);
}

/// Removes wedges that no triangle uses (a pole's last corner).
fn drop_unused(p: &mut Primitive) {
    let mut place = vec![u32::MAX; p.positions.len()];
    p.indices.iter().for_each(|&i| place[i as usize] = 0);
    let keep: Vec<usize> = (0..place.len()).filter(|&i| place[i] == 0).collect();
    keep.iter().enumerate().for_each(|(n, &i)| place[i] = n as u32);
    p.positions = keep.iter().map(|&i| p.positions[i]).collect();
    p.normals = keep.iter().map(|&i| p.normals[i]).collect();
    p.uvs = keep.iter().map(|&i| p.uvs[i]).collect();
    p.indices.iter_mut().for_each(|i| *i = place[*i as usize]);
}

fn still(name: &str, primitives: Vec<Primitive>, materials: Vec<Material>, images: Vec<Vec<u8>>) -> Document {
    Document {
        nodes: vec![Node { name: name.into(), mesh: Some(0), ..Node::default() }],
        meshes: vec![(name.into(), primitives)],
        materials,
        images,
        ..Document::default()
    }
}

/// A tube of two metres, straight in bind pose, bent by a right angle in its clip. Square and flat-sided, or round.
fn tube(square: bool) -> Document {
    let mut p = Primitive::default();
    let columns = if square { 16 } else { 12 };
    let ring = |u: f32| {
        // Whole columns only: the first and the last, and the lids', must be the same positions bit for bit.
        let u = ((u * columns as f32 + 0.5) as usize % columns) as f32 / columns as f32;
        let (s, c) = libm::sincosf(TAU * u);
        if !square {
            return (vec2(s, c) * 0.2, vec2(s, c));
        }
        let side = ((u * 4.0) as usize).min(3);
        let t = (u * 4.0 - side as f32) * 0.4 - 0.2;
        let (out, along) = [
            (vec2(0., 1.), vec2(1., 0.)),
            (vec2(1., 0.), vec2(0., -1.)),
            (vec2(0., -1.), vec2(-1., 0.)),
            (vec2(-1., 0.), vec2(0., 1.)),
        ][side];
        (out * 0.2 + along * t, out + along * (t / 0.4))
    };
    let body = |u: f32, v: f32| {
        let (at, out) = ring(u);
        (vec3(at.x, 2.0 * v, at.y), vec3(out.x, 0.0, out.y).normalize())
    };
    add_grid(&mut p, columns, 20, &body, &|u, v| vec2(u, 1.0 - v));
    for (y, up) in [(2.0, 1.0_f32), (0.0, -1.0)] {
        let lid = |u: f32, v: f32| {
            let at = ring(if up > 0.0 { u } else { 1.0 - u }).0 * (1.0 - v);
            (vec3(at.x, y, at.y), vec3(0.0, up, 0.0))
        };
        add_grid(&mut p, columns, 1, &lid, &|u, v| vec2(u, v * 0.1));
    }
    for q in &p.positions {
        let bend = smoothstep(0.85, 1.15, q[1]);
        p.joints.push([0, u8::from(bend > 0.0), 0, 0]);
        p.weights.push([1.0 - bend, bend, 0.0, 0.0]);
    }
    let nodes = vec![
        Node { name: "tube".into(), mesh: Some(0), skinned: true, ..Node::default() },
        Node { name: "lower".into(), children: vec![2], ..Node::default() },
        Node { name: "upper".into(), translation: Vec3::Y, ..Node::default() },
    ];
    let keys = [0.0, 30.0, 60.0, 90.0, 60.0, 30.0, 0.0];
    let clip = Clip {
        name: "bend".into(),
        times: (0..keys.len()).map(|k| k as f32 / 3.0).collect(),
        curves: vec![(2, Curve::Rotation(keys.iter().map(|&d| turn(Vec3::X, d)).collect()))],
    };
    Document {
        nodes,
        meshes: vec![("tube".into(), vec![p])],
        joints: vec![(1, Vec3::ZERO), (2, Vec3::Y)],
        materials: vec![painted("chequered", Some(0), [1.0; 4])],
        images: vec![chequered(64, [235, 180, 90], [70, 110, 160])],
        clips: vec![clip],
    }
}

fn sphere() -> Document {
    let mut p = Primitive::default();
    let at = |u: f32, v: f32| {
        // Both ends of a row must be the same position, bit for bit.
        let (s, c) = libm::sincosf(if u == 1.0 { 0.0 } else { TAU * u });
        let (sv, cv) = if v == 0.0 {
            (0.0, -1.0)
        } else if v == 1.0 {
            (0.0, 1.0)
        } else {
            (libm::sinf(0.5 * TAU * v), -libm::cosf(0.5 * TAU * v))
        };
        let n = vec3(s * sv, cv, c * sv);
        (n + Vec3::Y, n)
    };
    add_grid(&mut p, 24, 12, &at, &|u, v| vec2(u, 1.0 - v));
    let materials = vec![painted("chequered", Some(0), [1.0; 4])];
    still("sphere", vec![p], materials, vec![chequered(64, [240, 220, 200], [190, 70, 60])])
}

fn cube() -> Document {
    let mut p = Primitive::default();
    let faces = [
        (Vec3::X, Vec3::NEG_Z),
        (Vec3::NEG_X, Vec3::Z),
        (Vec3::Z, Vec3::X),
        (Vec3::NEG_Z, Vec3::NEG_X),
        (Vec3::Y, Vec3::X),
        (Vec3::NEG_Y, Vec3::X),
    ];
    for (k, (n, u)) in faces.into_iter().enumerate() {
        let v = n.cross(u);
        let at = |a: f32, b: f32| (n * 0.5 + u * (a - 0.5) + v * (b - 0.5) + Vec3::Y * 0.5, n);
        let corner = vec2((k % 3) as f32 / 3.0 + 0.02, (k / 3) as f32 / 2.0 + 0.02);
        add_grid(&mut p, 4, 4, &at, &|a, b| corner + vec2(a * 0.29, (1.0 - b) * 0.46));
    }
    let materials = vec![painted("chequered", Some(0), [1.0; 4])];
    still("cube", vec![p], materials, vec![chequered(64, [250, 210, 120], [60, 130, 120])])
}

/// A cushion whose upper half is one material and whose lower half is another.
fn two_materials() -> Document {
    let half = |up: f32, material: usize| {
        let mut p = Primitive { material, ..Primitive::default() };
        let at = |u: f32, v: f32| {
            // The lower half runs the other way round over the same columns, so that both rims are the same positions.
            let k = (u * 16.0 + 0.5) as usize % 16;
            let k = if up > 0.0 { k } else { (16 - k) % 16 };
            let (s, c) = libm::sincosf(TAU * k as f32 / 16.0);
            let (sv, cv) = libm::sincosf(0.25 * TAU * v);
            let ring = if v == 1.0 { 0.0 } else { cv };
            let n = vec3(s * ring, sv * up, c * ring);
            (n * vec3(0.6, 0.4, 0.6) + Vec3::Y * 0.5, n)
        };
        add_grid(&mut p, 16, 6, &at, &|u, v| vec2(u, 0.5 + 0.5 * v * up));
        if material == 0 {
            p.uvs.clear();
        }
        p
    };
    let materials = vec![painted("red", None, [0.6, 0.05, 0.06, 1.0]), painted("chequered", Some(0), [1.0; 4])];
    still("cushion", vec![half(1.0, 0), half(-1.0, 1)], materials, vec![chequered(64, [230, 230, 240], [80, 80, 150])])
}

/// A skinned post with a head joint, and an unskinned hat on a node under that joint.
fn hat() -> Document {
    let lathe = |rows: &[(f32, f32)], columns: usize| {
        let mut p = Primitive::default();
        let n = rows.len() - 1;
        let at = |u: f32, v: f32| {
            let (s, c) = libm::sincosf(if u == 1.0 { 0.0 } else { TAU * u });
            let k = (v * n as f32 + 0.5) as usize;
            let (r, y) = rows[k];
            let (a, b) = (rows[k.saturating_sub(1)], rows[(k + 1).min(n)]);
            let slope = vec2(b.1 - a.1, a.0 - b.0);
            (vec3(s * r, y, c * r), vec3(s * slope.x, slope.y, c * slope.x).normalize())
        };
        add_grid(&mut p, columns, n, &at, &|u, v| vec2(u, 1.0 - v));
        p
    };
    let mut body = lathe(
        &[
            (0.0, 0.0),
            (0.25, 0.0),
            (0.22, 0.3),
            (0.16, 0.7),
            (0.10, 1.0),
            (0.2, 1.1),
            (0.24, 1.3),
            (0.16, 1.48),
            (0.0, 1.52),
        ],
        12,
    );
    for q in &body.positions {
        let head = smoothstep(0.85, 1.1, q[1]);
        body.joints.push([0, u8::from(head > 0.0), 0, 0]);
        body.weights.push([1.0 - head, head, 0.0, 0.0]);
    }
    let mut hat = lathe(&[(0.0, 0.0), (0.42, 0.0), (0.43, 0.03), (0.22, 0.05), (0.2, 0.28), (0.0, 0.34)], 16);
    hat.material = 1;
    hat.uvs.clear();
    let nodes = vec![
        Node { name: "body".into(), mesh: Some(0), skinned: true, ..Node::default() },
        Node { name: "foot".into(), children: vec![2], ..Node::default() },
        Node { name: "head".into(), children: vec![3], translation: Vec3::Y, ..Node::default() },
        Node { name: "hat".into(), mesh: Some(1), translation: vec3(0.0, 0.42, 0.0), ..Node::default() },
    ];
    let nod = [0.0, 25.0, 35.0, 25.0, 0.0, -15.0, 0.0];
    let clip = Clip {
        name: "nod".into(),
        times: (0..nod.len()).map(|k| k as f32 * 0.25).collect(),
        curves: vec![(2, Curve::Rotation(nod.iter().map(|&d| turn(vec3(1.0, 0.0, 0.3), d)).collect()))],
    };
    Document {
        nodes,
        meshes: vec![("body".into(), vec![body]), ("hat".into(), vec![hat])],
        joints: vec![(1, Vec3::ZERO), (2, Vec3::Y)],
        materials: vec![painted("chequered", Some(0), [1.0; 4]), painted("felt", None, [0.05, 0.12, 0.08, 1.0])],
        images: vec![chequered(64, [240, 200, 160], [200, 120, 90])],
        clips: vec![clip],
    }
}

/// A closed pebble whose texture is laid on from above, cut twice: each cut is a seam with two ends inside the chart.
fn two_seams() -> Document {
    const N: usize = 12;
    let mut p = Primitive::default();
    let height = |x: f32, z: f32| 0.35 * (1.0 - x * x).max(0.0).sqrt() * (1.0 - z * z).max(0.0).sqrt();
    let place = |i: usize| i as f32 / N as f32 * 2.0 - 1.0;
    let uv = |i: usize, j: usize| vec2(i as f32, j as f32) / N as f32 * 0.9 + 0.05;
    let mut top = vec![0_u32; (N + 1) * (N + 1)];
    let mut low = top.clone();
    let push = |p: &mut Primitive, i: usize, j: usize, up: f32, shift: f32| {
        let (x, z) = (place(i), place(j));
        p.positions.push([x, 0.4 + up * height(x, z), z]);
        p.normals.push(vec3(x * 0.4, up * (1.05 - x * x) * (1.05 - z * z), z * 0.4).normalize().to_array());
        p.uvs.push((uv(i, j) + vec2(0.0, shift)).to_array());
        p.positions.len() as u32 - 1
    };
    for j in 0..=N {
        for i in 0..=N {
            let k = j * (N + 1) + i;
            top[k] = push(&mut p, i, j, 1.0, 0.0);
            let rim = i == 0 || j == 0 || i == N || j == N;
            low[k] = if rim { top[k] } else { push(&mut p, i, j, -1.0, 0.0) };
        }
    }
    // The cuts: rows 4 and 8, columns 3..=9; their inner positions have a second wedge for the faces beyond.
    let cut = |i: usize, j: usize| (j == 4 || j == 8) && i > 3 && i < 9;
    let mut beyond = top.clone();
    for j in [4, 8] {
        for i in 4..9 {
            beyond[j * (N + 1) + i] = push(&mut p, i, j, 1.0, 0.02);
        }
    }
    for j in 0..N {
        for i in 0..N {
            let at = |di: usize, dj: usize, list: &[u32]| list[(j + dj) * (N + 1) + i + di];
            let pick =
                |di: usize, dj: usize| if dj == 0 && cut(i + di, j) { at(di, 0, &beyond) } else { at(di, dj, &top) };
            let t = [pick(0, 0), pick(0, 1), pick(1, 1), pick(1, 0)];
            let l = [at(0, 0, &low), at(0, 1, &low), at(1, 1, &low), at(1, 0, &low)];
            // No triangle may have all its corners on the rim: it would lie on its own twin below.
            let k = usize::from((i == N - 1 && j == 0) || (i == 0 && j == N - 1));
            let [a, b, c, d] = [k, k + 1, (k + 2) % 4, (k + 3) % 4];
            p.indices.extend([t[a], t[b], t[c], t[a], t[c], t[d]]);
            p.indices.extend([l[a], l[c], l[b], l[a], l[d], l[c]]);
        }
    }
    let materials = vec![painted("chequered", Some(0), [1.0; 4])];
    still("pebble", vec![p], materials, vec![chequered(64, [200, 220, 190], [90, 140, 100])])
}

/// One skinned triangle with a clip: the least that is a character.
pub fn triangle() -> Document {
    let p = Primitive {
        positions: vec![[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [0.5, 0.0]],
        joints: vec![[0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0]],
        weights: vec![[1.0, 0.0, 0.0, 0.0]; 3],
        indices: vec![0, 1, 2],
        material: 0,
    };
    Document {
        nodes: vec![
            Node { name: "flag".into(), mesh: Some(0), skinned: true, ..Node::default() },
            Node { name: "foot".into(), children: vec![2], ..Node::default() },
            Node { name: "top".into(), translation: Vec3::Y, ..Node::default() },
        ],
        meshes: vec![("flag".into(), vec![p])],
        joints: vec![(1, Vec3::ZERO), (2, Vec3::Y)],
        materials: vec![painted("chequered", Some(0), [1.0; 4])],
        images: vec![chequered(16, [255, 220, 120], [180, 60, 60])],
        clips: vec![Clip {
            name: "wave".into(),
            times: vec![0.0, 0.5, 1.0],
            curves: vec![(2, Curve::Rotation([0.0, 40.0, 0.0].map(|d| turn(Vec3::Z, d)).to_vec()))],
        }],
    }
}

/// A wooden crate as OBJ: positions and texture corners are counted apart, faces are quads.
fn crate_obj() -> Vec<Fixture> {
    let mut text = String::from(
        "# Separate v, vt and vn indices; quads; relative (negative) indices in the last face.\nmtllib painted_crate.mtl\no painted_crate\n",
    );
    for k in 0..8 {
        let s = |bit: usize| if k >> bit & 1 == 1 { 0.5 } else { -0.5 };
        text += &format!("v {} {} {}\n", s(0), s(1) + 0.5, s(2));
    }
    text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let normals = ["0 0 1", "0 0 -1", "1 0 0", "-1 0 0", "0 1 0", "0 -1 0"];
    normals.iter().for_each(|n| text += &format!("vn {n}\n"));
    text += "usemtl planks\ns off\n";
    let faces = [[5, 6, 8, 7], [2, 1, 3, 4], [6, 2, 4, 8], [1, 5, 7, 3], [7, 8, 4, 3]];
    for (n, f) in faces.iter().enumerate() {
        let corners: Vec<String> = (0..4).map(|k| format!("{}/{}/{}", f[k], k + 1, n + 1)).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    text += "f -8/-4/-1 -7/-3/-1 -3/-2/-1 -4/-1/-1\n";
    let mtl = "newmtl planks\nKd 1 1 1\nillum 1\nmap_Kd painted_crate.png\n";
    let mut bytes = Vec::new();
    for y in 0..128_u32 {
        for x in 0..128_u32 {
            let frame = !(14..114).contains(&x) || !(14..114).contains(&y);
            let brace = (x as i32 - y as i32).abs() < 10;
            let plank = if frame || brace { 0 } else { x / 20 };
            let gap = !frame && !brace && x % 20 == 14 || (frame && (x == 13 || y == 13 || x == 114 || y == 114));
            let nail =
                [(7, 7), (120, 7), (7, 120), (120, 120)].iter().any(|&(a, b)| x.abs_diff(a) < 2 && y.abs_diff(b) < 2);
            let grain = libm::sinf((x as f32) * 0.9 + 3.0 * libm::sinf(y as f32 * 0.07 + plank as f32)) * 7.0;
            let light = if gap {
                0.45
            } else if nail {
                0.6
            } else if frame || brace {
                0.82
            } else {
                1.0 - 0.04 * (plank % 3) as f32
            };
            bytes.extend([190.0, 132.0, 78.0].map(|c: f32| ((c + grain) * light).clamp(0.0, 255.0) as u8));
        }
    }
    vec![
        Fixture { path: "good/painted_crate.obj".into(), bytes: text.into_bytes() },
        Fixture { path: "good/painted_crate.mtl".into(), bytes: mtl.into() },
        Fixture { path: "good/painted_crate.png".into(), bytes: png(&bytes, 128, ExtendedColorType::Rgb8) },
    ]
}
