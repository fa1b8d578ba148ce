//! Packs made on the spot: a post that bends in its clip, with a level for each of its rings.

use crowd_pack::*;
use std::f32::consts::TAU;
use std::path::Path;

const SIDES: usize = 12;
/// One more than sides: the seam's column stands twice.
const COLUMNS: usize = SIDES + 1;
const RINGS: usize = 17;
const FRAMES: usize = 16;

/// A post to put into a pack.
pub struct Post {
    pub name: &'static str,
    pub height_m: f32,
    /// Linear factor; textured posts multiply it with their checks.
    pub color: [f32; 3],
    pub textured: bool,
}

/// Two kinds of posts: one checked, one plain and half as high.
pub const TWO_POSTS: [Post; 2] = [
    Post { name: "Ada", height_m: 1.7, color: [1.0, 1.0, 1.0], textured: true },
    Post { name: "Bruno", height_m: 0.9, color: [0.8, 0.25, 0.1], textured: false },
];

/// Writes a pack of these posts.
pub fn write_pack(path: &Path, posts: &[Post]) {
    contents(posts).write(path).expect("the posts are valid and the folder is ours");
}

/// Each post has a clip `Idle` (a single pose) and a clip `Sway` (a second long).
pub fn contents(posts: &[Post]) -> PackContents {
    let mut pack =
        PackContents { manifest: Manifest { generator: "test".into(), ..Default::default() }, ..Default::default() };
    let png = checks_png();
    pack.images.push(ImageRecord { byte_count: png.len() as u64, width: 16, height: 16, ..Default::default() });
    pack.image_bytes = png;
    for post in posts {
        push_post(&mut pack, post);
    }
    pack.store_end_levels();
    pack
}

fn push_post(pack: &mut PackContents, post: &Post) {
    let order = ring_order();
    let place = |ring: usize| order.iter().position(|&r| r == ring).expect("every ring is in the order");
    let (vertex_offset, triangle_offset, lod_offset) = (pack.vertices.len(), pack.triangles.len(), pack.lods.len());
    for &ring in &order {
        for column in 0..COLUMNS {
            pack.vertices.push(vertex(post, ring, column));
            let target = if ring == 0 || ring == RINGS - 1 { ring } else { ring - (ring & ring.wrapping_neg()) };
            pack.collapse_map.push((place(target) * COLUMNS + column) as u32);
        }
    }
    // The gap below a ring opens when the ring comes: triangles in the order of their upper rings.
    for &upper in order.iter().filter(|&&ring| ring > 0) {
        for column in 0..SIDES {
            let corner = |ring: usize, column: usize| (place(ring) * COLUMNS + column) as u32;
            let [a, b] = [corner(upper - 1, column), corner(upper - 1, column + 1)];
            let [c, d] = [corner(upper, column + 1), corner(upper, column)];
            pack.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let level = |rings: usize| LodRecord {
        vertex_count: (rings * COLUMNS) as u32,
        triangle_count: ((rings - 1) * 2 * SIDES) as u32,
    };
    pack.lods.extend((0..=RINGS * COLUMNS).map(|k| level((k / COLUMNS).clamp(2, RINGS))));
    let clip_offset = pack.clips.len();
    for frames in [1, FRAMES] {
        push_clip(pack, post, frames);
    }
    let material_offset = pack.materials.len();
    pack.materials.push(MaterialRecord {
        base_color: [post.color[0], post.color[1], post.color[2], 1.0],
        image: if post.textured { 0 } else { NONE },
        ..Default::default()
    });
    let (least, full) = (level(2), level(RINGS));
    pack.characters.push(CharacterRecord {
        vertex_offset: vertex_offset as u32,
        vertex_count: full.vertex_count,
        triangle_offset: triangle_offset as u32,
        triangle_count: full.triangle_count,
        lod_offset: lod_offset as u32,
        min_vertex_count: least.vertex_count,
        min_triangle_count: least.triangle_count,
        joint_count: 2,
        clip_offset: clip_offset as u32,
        clip_count: 2,
        material_offset: material_offset as u32,
        material_count: 1,
        sphere: [0.0, 0.5 * post.height_m, 0.0, 0.8 * post.height_m],
        box_min: [-post.height_m, -0.1, -post.height_m],
        height_m: post.height_m,
        box_max: [post.height_m; 3],
        ..Default::default()
    });
    let node = ManifestNode { rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3], ..Default::default() };
    let clip = |name: &str| ManifestClip { name: name.into(), ..Default::default() };
    pack.manifest.characters.push(ManifestCharacter {
        name: post.name.into(),
        source: "made.glb".into(),
        nodes: vec![node],
        joints: vec![ManifestJoint::default(); 2],
        clips: vec![clip("Idle"), clip("Sway")],
        materials: vec!["only".into()],
        criteria: "wedge".into(),
        fps: 16.0,
        ..Default::default()
    });
}

/// Ends, middle, quarters, eighths, ...: each ring collapses onto the one below it that came before.
fn ring_order() -> Vec<usize> {
    let mut order = vec![0, RINGS - 1];
    let mut step = (RINGS - 1) / 2;
    while step > 0 {
        order.extend((step..RINGS - 1).step_by(2 * step));
        step /= 2;
    }
    order
}

fn vertex(post: &Post, ring: usize, column: usize) -> VertexRecord {
    let up = ring as f32 / (RINGS - 1) as f32;
    let (sin, cos) = libm::sincosf(TAU * (column % SIDES) as f32 / SIDES as f32);
    let radius = 0.16 * post.height_m * (0.15 + libm::sinf(0.5 + 2.5 * up));
    let bend = (2.0 * up - 0.5).clamp(0.0, 1.0);
    VertexRecord::new(
        [radius * sin, up * post.height_m, radius * cos],
        [sin, 0.2, cos],
        [column as f32 / SIDES as f32, 1.0 - up],
        [1.0, 1.0 - 0.4 * up, 1.0, 1.0],
        0,
        0,
        [0, 1, 0, 0],
        [1.0 - bend, bend, 0.0, 0.0],
    )
}

/// The second joint turns about the post's middle, as a pendulum.
fn push_clip(pack: &mut PackContents, post: &Post, frames: usize) {
    let texel_offset = pack.animation.len() as u32;
    let middle = 0.45 * post.height_m;
    for frame in 0..frames {
        let share = frame as f32 / (frames.max(2) - 1) as f32;
        let (s, c) = libm::sincosf(0.5 * libm::sinf(TAU * share));
        let still = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let turned = [[c, -s, 0.0, s * middle], [s, c, 0.0, middle - c * middle], [0.0, 0.0, 1.0, 0.0]];
        crowd_pack::store_frame(crowd_pack::JointStorage::F32, &[still, turned], &mut pack.animation);
    }
    pack.clips.push(ClipRecord {
        texel_offset,
        frame_count: frames as u32,
        duration_s: if frames > 1 { 1.0 } else { 0.0 },
        sphere: [0.0, 0.5 * post.height_m, 0.0, 0.8 * post.height_m],
        ..Default::default()
    });
}

fn checks_png() -> Vec<u8> {
    let image = image::RgbImage::from_fn(16, 16, |x, y| {
        image::Rgb(if (x / 4 + y / 4) % 2 == 0 { [235, 215, 160] } else { [50, 80, 150] })
    });
    let mut bytes = Vec::new();
    image
        .write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png)
        .expect("sixteen pixels fit into memory");
    bytes
}
