//! Charts into the texture: where each chart lies, and how its triangles are painted from their place on the body.
//!
//! The painter is asked for a colour at a bind-pose position, never at a texel, so that a pattern runs on across every
//! seam; what is torn later is torn by whoever moved a wedge.

use glam::{Vec2, Vec3};

use crate::shape::{Corner, Shape};

/// Chart rectangles (x0, y0, x1, y1) in sixteenths of the texture; indices are [`crate::body::chart`].
pub const HUMAN: &[[u8; 4]] = &[
    [0, 0, 7, 7],
    [7, 0, 11, 5],
    [11, 0, 14, 3],
    [0, 7, 5, 12],
    [5, 7, 10, 12],
    [0, 12, 4, 14],
    [0, 14, 4, 16],
    [10, 7, 14, 12],
    [14, 7, 16, 10],
    [14, 0, 15, 1],
    [15, 0, 16, 1],
    [14, 1, 15, 2],
    [15, 1, 16, 2],
    [14, 2, 15, 3],
    [15, 2, 16, 3],
    [4, 12, 10, 16],
    [10, 12, 14, 16],
    [14, 12, 16, 14],
    [11, 3, 16, 7],
    [7, 5, 11, 7],
    [14, 14, 16, 16],
    [14, 10, 16, 12],
    [14, 14, 16, 16],
];

/// The same for people in skirts: the skirt lies where the hips were, and those are small.
pub const SKIRTED: &[[u8; 4]] = &{
    let mut rects = [[0_u8; 4]; 23];
    let mut i = 0;
    while i < rects.len() {
        rects[i] = HUMAN[i];
        i += 1;
    }
    rects[5] = [14, 14, 15, 16];
    rects[6] = [15, 14, 16, 16];
    rects[17] = [14, 12, 16, 13];
    rects[20] = [0, 12, 4, 16];
    rects[22] = [14, 13, 16, 14];
    rects
};

/// Chart rectangles of the four-legged animals.
pub const BEAST: &[[u8; 4]] = &[
    [0, 0, 16, 7],
    [0, 7, 4, 13],
    [4, 7, 8, 13],
    [8, 7, 11, 10],
    [11, 7, 13, 10],
    [13, 7, 16, 10],
    [8, 10, 12, 13],
    [12, 10, 16, 13],
    [0, 13, 8, 16],
    [8, 13, 16, 16],
];

/// Texels left free around each chart, as a share of the texture (5 of 512).
const GUTTER: f32 = 5.0 / 512.0;

/// What the painter is told about the point it paints.
pub struct Spot {
    /// Bind-pose position in metres.
    pub position: Vec3,
    /// Bind-pose unit normal.
    pub normal: Vec3,
    /// Body part.
    pub part: u8,
    /// See [`Corner::along`].
    pub along: f32,
    /// See [`Corner::around`].
    pub around: f32,
}

/// A painted texture and its region map, row by row from the top.
pub struct Painting {
    /// Width and height in texels.
    pub size: u32,
    /// Base colour, sRGB, three bytes each.
    pub colour: Vec<u8>,
    /// Region id of each texel; 0 where no chart lies.
    pub regions: Vec<u8>,
}

/// Texture coordinate (0..1, v down) of a corner.
pub fn texture_uv(rects: &[[u8; 4]], chart: u16, uv: Vec2) -> Vec2 {
    let r = rects[chart as usize].map(|x| x as f32 / 16.0);
    let (low, high) = (Vec2::new(r[0], r[1]) + GUTTER, Vec2::new(r[2], r[3]) - GUTTER);
    low + (high - low) * uv
}

/// Paints all charts of `shape` into a square of `size` texels, four samples per texel, then spreads the border colours
/// outwards so that filtering never reaches an unpainted texel.
///
/// `painter` returns an sRGB colour (0..1) and a region id (1..).
pub fn paint(shape: &Shape, rects: &[[u8; 4]], size: u32, painter: &dyn Fn(&Spot) -> (Vec3, u8)) -> Painting {
    let normals = shape.normals();
    let n = size as usize;
    let mut sum = vec![Vec3::ZERO; n * n];
    let mut hits = vec![0_u8; n * n];
    let mut regions = vec![0_u8; n * n];
    for (face, t) in shape.triangles() {
        let face = &shape.faces[face];
        if face.mirrored {
            continue;
        }
        let uv = t.map(|c| texture_uv(rects, face.chart, c.chart_uv) * size as f32);
        let area = (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]);
        if area.abs() < 1e-9 {
            continue;
        }
        let low = uv[0].min(uv[1]).min(uv[2]).max(Vec2::ZERO);
        let high = uv[0].max(uv[1]).max(uv[2]).min(Vec2::splat(size as f32 - 1.0));
        for y in low.y as usize..=high.y as usize {
            for x in low.x as usize..=high.x as usize {
                for s in 0..4 {
                    let p = Vec2::new(
                        x as f32 + [0.375, 0.875, 0.125, 0.625][s],
                        y as f32 + [0.125, 0.375, 0.625, 0.875][s],
                    );
                    let b = [
                        (uv[1] - p).perp_dot(uv[2] - p) / area,
                        (uv[2] - p).perp_dot(uv[0] - p) / area,
                        (uv[0] - p).perp_dot(uv[1] - p) / area,
                    ];
                    if b.iter().any(|&w| w < -1e-5) {
                        continue;
                    }
                    let mean = |f: &dyn Fn(&Corner) -> f32| b[0] * f(&t[0]) + b[1] * f(&t[1]) + b[2] * f(&t[2]);
                    let at = |list: &[Vec3]| (0..3).map(|k| list[t[k].position as usize] * b[k]).sum::<Vec3>();
                    let spot = Spot {
                        position: at(&shape.positions),
                        normal: at(&normals).normalize_or_zero(),
                        part: face.part,
                        along: mean(&|c| c.along),
                        around: mean(&|c| c.around),
                    };
                    let (colour, region) = painter(&spot);
                    let i = y * n + x;
                    sum[i] += colour;
                    hits[i] = hits[i].saturating_add(1);
                    if regions[i] == 0 || s == 2 {
                        regions[i] = region;
                    }
                }
            }
        }
    }
    let mut colour: Vec<Vec3> = (0..n * n).map(|i| sum[i] / hits[i].max(1) as f32).collect();
    let mut done: Vec<bool> = hits.iter().map(|&h| h > 0).collect();
    spread(&mut colour, &mut regions, &mut done, n, (size / 64) as usize);
    let painted = done.iter().filter(|&&d| d).count().max(1);
    let mean = (0..n * n).filter(|&i| done[i]).map(|i| colour[i]).sum::<Vec3>() / painted as f32;
    let mut bytes = Vec::with_capacity(3 * n * n);
    for i in 0..n * n {
        let c = if done[i] { colour[i] } else { mean };
        bytes.extend(c.to_array().map(|x| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8));
    }
    Painting { size, colour: bytes, regions }
}

/// Grows painted texels by one texel per round, from their four neighbours.
fn spread(colour: &mut [Vec3], regions: &mut [u8], done: &mut [bool], n: usize, rounds: usize) {
    for _ in 0..rounds {
        let before = done.to_vec();
        for i in 0..n * n {
            if before[i] {
                continue;
            }
            let (x, y) = (i % n, i / n);
            let near = [
                (x > 0).then(|| i - 1),
                (x + 1 < n).then(|| i + 1),
                (y > 0).then(|| i - n),
                (y + 1 < n).then(|| i + n),
            ];
            let near: Vec<usize> = near.into_iter().flatten().filter(|&j| before[j]).collect();
            if let Some(&first) = near.first() {
                colour[i] = near.iter().map(|&j| colour[j]).sum::<Vec3>() / near.len() as f32;
                regions[i] = regions[first];
                done[i] = true;
            }
        }
    }
}
