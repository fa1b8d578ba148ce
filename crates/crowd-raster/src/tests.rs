//! What a picture must show, over all steps: drawn into small targets.

use glam::{Mat4, Vec3};

use crate::*;

const WHITE: [u8; 4] = [255, 255, 255, 255];
const BLACK: [u8; 4] = [0, 0, 0, 255];

/// Owned vertices for a batch.
#[derive(Default, Clone)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    colors: Vec<[u8; 4]>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    fill: Fill,
}

impl Mesh {
    fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        Self { positions: positions.to_vec(), triangles: triangles.to_vec(), materials: vec![UNLIT], ..Self::default() }
    }

    fn batch(&self) -> Batch<'_> {
        Batch {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            colors: &self.colors,
            vertex_materials: &[],
            triangles: &self.triangles,
            materials: &self.materials,
            textures: &self.textures,
            fill: self.fill,
        }
    }
}

const UNLIT: Material = Material {
    base_color: [1.0; 4],
    texture: None,
    wrap_u: Wrap::Clamp,
    wrap_v: Wrap::Clamp,
    alpha_cutoff: 0.0,
    double_sided: false,
    unlit: true,
    flat: false,
};

/// World space is clip space: x and y from -1 to 1, z the depth.
const FLAT_VIEW: View = View { clip_from_world: Mat4::IDENTITY, eye: Vec3::ZERO };

fn perspective_view(eye: Vec3, at: Vec3, aspect: f32) -> View {
    let clip = glam::camera::rh::proj::directx::perspective(1.0, aspect, 0.1, 200.0);
    View { clip_from_world: clip * glam::camera::rh::view::look_at_mat4(eye, at, Vec3::Y), eye }
}

fn covered(mesh: &Mesh, view: &View, width: u32, height: u32) -> Vec<bool> {
    let mut target = Target::new(width, height, BLACK);
    draw(&mut target, view, &mesh.batch());
    target.depth.iter().map(|&depth| depth < 1.0).collect()
}

/// A number below 1 from a counter, for scattered test meshes.
fn scatter(counter: &mut u32) -> f32 {
    *counter = counter.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*counter >> 8) as f32 / (1 << 24) as f32
}

#[test]
fn triangles_that_share_edges_cover_each_pixel_exactly_once() {
    // A fan around a point over the whole picture, its corners on pixel centres, pixel corners and in between.
    let mut counter = 7;
    for round in 0..200 {
        let snap = |v: f32| if round % 2 == 0 { (v * 32.0).round() / 32.0 } else { v };
        let middle = [snap(scatter(&mut counter) - 0.5), snap(scatter(&mut counter) - 0.5), 0.5];
        let (side, edge) = (snap(scatter(&mut counter)), 2.0);
        let rim = [[-edge, -edge], [side, -edge], [edge, -edge], [edge, side], [edge, edge], [-edge, edge]];
        let mut mesh = Mesh::new(&[middle], &[]);
        mesh.positions.extend(rim.map(|[x, y]| [x, y, 0.5]));
        let mut count = vec![0; 16 * 16];
        for i in 0..6 {
            mesh.triangles = vec![[0, 1 + i, 1 + (i + 1) % 6]];
            for (count, covered) in count.iter_mut().zip(covered(&mesh, &FLAT_VIEW, 16, 16)) {
                *count += u32::from(covered);
            }
        }
        assert!(count.iter().all(|&count| count == 1), "round {round}: {count:?}");
    }
}

#[test]
fn the_top_left_rule_gives_points_on_an_edge_to_one_side() {
    // A square whose edges run through pixel centres of a 4 x 4 picture: left and top centres are in, right and bottom out.
    let mesh = Mesh::new(
        &[[-0.75, -0.25, 0.5], [0.25, -0.25, 0.5], [0.25, 0.75, 0.5], [-0.75, 0.75, 0.5]],
        &[[0, 1, 2], [0, 2, 3]],
    );
    let picture: Vec<usize> =
        covered(&mesh, &FLAT_VIEW, 4, 4).iter().enumerate().filter_map(|(i, &c)| c.then_some(i)).collect();
    assert_eq!(picture, [0, 1, 4, 5]);
}

#[test]
fn only_counter_clockwise_sides_are_seen_unless_double_sided() {
    let mut mesh = Mesh::new(&[[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [0.0, 1.0, 0.5]], &[[0, 1, 2]]);
    assert!(covered(&mesh, &FLAT_VIEW, 8, 8).contains(&true));
    mesh.triangles = vec![[0, 2, 1]];
    assert!(!covered(&mesh, &FLAT_VIEW, 8, 8).contains(&true));
    mesh.materials[0].double_sided = true;
    assert!(covered(&mesh, &FLAT_VIEW, 8, 8).contains(&true));
}

#[test]
fn a_double_sided_back_is_lit_as_a_front_of_the_turned_normal() {
    let mut mesh = Mesh::new(&[[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [0.0, 1.0, 0.5]], &[[0, 2, 1]]);
    mesh.materials[0] = Material { unlit: false, double_sided: true, ..UNLIT };
    mesh.normals = vec![[0.0, -1.0, 0.0]; 3];
    let mut target = Target::new(4, 4, BLACK);
    draw(&mut target, &FLAT_VIEW, &mesh.batch());
    assert_eq!(target.color[2 * 4 + 2], srgb::encode_rgb(light::light_at(Vec3::Y)));
}

#[test]
fn nearer_wins_in_either_order_and_the_first_of_equals_stays() {
    let square = |z: f32, color: [u8; 4]| {
        let mut mesh =
            Mesh::new(&[[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]], &[[0, 1, 2], [0, 2, 3]]);
        mesh.colors = vec![color; 4];
        mesh.fill = Fill::VertexColor;
        mesh
    };
    let (near, far) = (square(0.25, WHITE), square(0.75, BLACK));
    for pair in [[near.batch(), far.batch()], [far.batch(), near.batch()]] {
        let mut target = Target::new(4, 4, [9; 4]);
        draw_many(&mut target, &FLAT_VIEW, &pair);
        assert!(target.color.iter().all(|&color| color == WHITE) && target.depth.iter().all(|&z| z == 0.25));
    }
    let same = square(0.25, BLACK);
    let mut target = Target::new(4, 4, [9; 4]);
    draw_many(&mut target, &FLAT_VIEW, &[near.batch(), same.batch()]);
    assert!(target.color.iter().all(|&color| color == WHITE));
}

#[test]
fn attributes_are_perspective_correct() {
    // A floor seen at a slant: the texture's halfway line is where the world's is, not halfway on the screen.
    let view = perspective_view(Vec3::new(0.0, 1.0, 1.0), Vec3::new(0.0, 0.0, -3.0), 1.0);
    let mut mesh =
        Mesh::new(&[[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 0.0, -12.0], [-3.0, 0.0, -12.0]], &[[0, 1, 2], [0, 2, 3]]);
    mesh.colors = vec![BLACK, BLACK, WHITE, WHITE];
    mesh.fill = Fill::VertexColor;
    let mut target = Target::new(200, 200, [9; 4]);
    draw(&mut target, &view, &mesh.batch());
    for z in [-2.0_f32, -4.0, -6.0, -9.0] {
        let ndc = view.clip_from_world.project_point3(Vec3::new(0.0, 0.0, z));
        let row = ((0.5 - ndc.y * 0.5) * 200.0) as usize;
        let found = srgb::decode_table()[usize::from(target.color[row * 200 + 100][0])];
        let wanted = -z / 12.0;
        assert!((found - wanted).abs() < 0.02 + 0.01 * wanted * -z, "z {z}: found {found}, wanted {wanted}");
    }
}

#[test]
fn a_floor_that_passes_under_the_eye_is_clipped_not_folded() {
    // From 50 m behind the eye to 50 m before it: below the horizon everything, above it nothing.
    let view = perspective_view(Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 2.0, -10.0), 1.0);
    let mut mesh = Mesh::new(
        &[[-500.0, 0.0, 500.0], [500.0, 0.0, 500.0], [500.0, 0.0, -150.0], [-500.0, 0.0, -150.0]],
        &[[0, 1, 2], [0, 2, 3]],
    );
    mesh.colors = mesh.positions.iter().map(|p| [if p[2] > 0.0 { 255 } else { 0 }, 0, 0, 255]).collect();
    let picture = covered(&mesh, &view, 64, 64);
    let horizon = view.clip_from_world.project_point3(Vec3::new(0.0, 0.0, -150.0));
    let first = ((0.5 - horizon.y * 0.5) * 64.0).round() as usize;
    for (i, &covered) in picture.iter().enumerate() {
        let row = i / 64;
        if row + 1 < first || row > first {
            assert_eq!(covered, row > first, "row {row}");
        }
    }
}

#[test]
fn texels_below_the_cutoff_are_holes() {
    let mut mesh =
        Mesh::new(&[[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [1.0, 1.0, 0.5], [-1.0, 1.0, 0.5]], &[[0, 1, 2], [0, 2, 3]]);
    mesh.uvs = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    mesh.textures =
        vec![Texture { mips: vec![Mip { width: 2, height: 1, texels: vec![[255, 0, 0, 0], [255, 0, 0, 255]] }] }];
    mesh.materials[0] = Material { texture: Some(0), alpha_cutoff: 0.5, ..UNLIT };
    let picture = covered(&mesh, &FLAT_VIEW, 8, 8);
    for (i, &covered) in picture.iter().enumerate() {
        assert_eq!(covered, i % 8 >= 4, "pixel {i}");
    }
    mesh.materials[0].alpha_cutoff = 0.0;
    assert!(!covered(&mesh, &FLAT_VIEW, 8, 8).contains(&false));
}

#[test]
fn a_wireframe_darkens_edges_and_leaves_the_middle() {
    let mut mesh = Mesh::new(&[[-0.9, -0.9, 0.5], [0.9, -0.9, 0.5], [0.0, 0.9, 0.5]], &[[0, 1, 2]]);
    mesh.fill = Fill::Wireframe;
    let mut target = Target::new(64, 64, BLACK);
    draw(&mut target, &FLAT_VIEW, &mesh.batch());
    assert_eq!(target.color[32 * 64 + 32], WHITE);
    let covered: Vec<&[u8; 4]> =
        target.color.iter().zip(&target.depth).filter(|(_, z)| **z < 1.0).map(|(c, _)| c).collect();
    let dark = covered.iter().filter(|color| color[0] < 200).count();
    assert!((100..300).contains(&dark), "{dark} of {}", covered.len());
}

/// Many small lit and textured triangles, some behind the eye, some large, some cut out.
fn scattered_scene() -> Mesh {
    let mut counter = 99;
    let mut mesh = Mesh::new(&[], &[]);
    for i in 0..3000_u32 {
        let size = if i % 100 == 0 { 8.0 } else { 0.4 };
        let centre = Vec3::new(scatter(&mut counter), scatter(&mut counter), scatter(&mut counter)) * 12.0 - 6.0;
        for _ in 0..3 {
            let away = Vec3::new(scatter(&mut counter), scatter(&mut counter), scatter(&mut counter)) - 0.5;
            mesh.positions.push((centre + away * size).to_array());
            mesh.normals.push(away.to_array());
            mesh.uvs.push([away.x * 3.0, away.y * 3.0]);
            mesh.colors.push([200, (i % 256) as u8, 90, 255]);
        }
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    let texels = (0..64).map(|i| [(i * 4) as u8, 255 - (i * 3) as u8, 128, (i * 5 % 256) as u8]).collect();
    mesh.textures = vec![Texture::from_rgba8(8, 8, texels)];
    mesh.materials = vec![Material {
        texture: Some(0),
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Mirror,
        alpha_cutoff: 0.3,
        double_sided: true,
        unlit: false,
        ..UNLIT
    }];
    mesh
}

fn draw_scene(batches: &[Batch<'_>]) -> Target {
    let view = perspective_view(Vec3::new(0.0, 2.0, 5.0), Vec3::ZERO, 1.5);
    let mut target = Target::new(150, 100, BLACK);
    draw_sky(&mut target, &view);
    draw_many(&mut target, &view, batches);
    draw_ground(&mut target, &view);
    target
}

#[test]
fn the_picture_depends_neither_on_threads_nor_on_batches() {
    let mesh = scattered_scene();
    let whole = draw_scene(&[mesh.batch()]);
    assert!(whole.depth.iter().filter(|z| **z < 1.0).count() > 5000);
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        assert_eq!(pool.install(|| draw_scene(&[mesh.batch()])), whole, "{threads} threads");
    }
    let parts: Vec<Batch<'_>> =
        mesh.triangles.chunks(70).map(|triangles| Batch { triangles, ..mesh.batch() }).collect();
    assert_eq!(draw_scene(&parts), whole);
}

#[test]
#[cfg_attr(not(target_arch = "x86_64"), ignore = "glam adds the terms of a product in another order on other machines")]
fn the_scene_is_still_the_golden_one() {
    // FNV-1a over the colours. It moves when a formula, a constant of `light` or the rounding of an operation does.
    let hash = draw_scene(&[scattered_scene().batch()])
        .color
        .iter()
        .flatten()
        .fold(0xcbf2_9ce4_8422_2325, |h, &byte| (h ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3_u64));
    assert_eq!(hash, GOLDEN, "{hash:#018x}");
}

const GOLDEN: u64 = 0x7adf_c518_f171_d599;

#[test]
fn broken_batches_are_passed_over() {
    let mut mesh = Mesh::new(&[[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [0.0, 1.0, f32::NAN]], &[[0, 1, 2], [0, 1, 9]]);
    mesh.materials = vec![Material { texture: Some(7), unlit: false, ..UNLIT }];
    assert!(!covered(&mesh, &FLAT_VIEW, 8, 8).contains(&true));
    mesh.positions[2][2] = 0.5;
    assert!(covered(&mesh, &FLAT_VIEW, 8, 8).contains(&true));
    let mut nothing = Target::new(0, 0, BLACK);
    draw(&mut nothing, &FLAT_VIEW, &mesh.batch());
    draw_sky(&mut nothing, &FLAT_VIEW);
    draw_ground(&mut nothing, &FLAT_VIEW);
}
