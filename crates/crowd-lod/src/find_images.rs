//! Finds, for each variant of a position that moves, the variant at the target that it becomes (Peng 2011 §4.2, the adjV groups).
//!
//! Across a triangle on the edge the image is plain: the same chart, the same smooth group. A wedge that has none there, as at
//! the corner of three charts, keeps what it shows: it becomes a *stand-in*, a new variant at the target with its old texture
//! coordinate and colour, or with the chart's coordinate and its old normal. So a texture may stretch at a seam, but never tears.

use crate::attributes::Attributes;
use crate::fan::Fan;
use crate::split_seams::{SplitMesh, cos_between};
use crate::topology::Topology;

/// Normals closer than this are one: a variant takes the image's normal without a stand-in. cos 37°.
const NORMAL_SPLIT_COS: f32 = 0.8;
/// Texture coordinates closer than this are one, squared: a quarter of a texel of 4096.
const SAME_UV_SQUARED: f32 = 3.7e-9;
/// Triangles at a hub that are searched for a variant; there is always one at hand to fall back on.
pub(crate) const SEARCHED_TRIANGLES: usize = 256;

/// What a variant becomes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Image {
    /// A variant at the target.
    Variant(u32),
    /// A new one, in a wedge at the target if that is known.
    StandIn { wedge: Option<u32>, uv_of: u32, normal_of: u32 },
}

/// One variant of the position that moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moved {
    pub variant: u32,
    pub image: Image,
    /// What its attributes cost then, m² times m².
    pub cost: f64,
}

/// What the images are looked up in.
#[derive(Clone, Copy)]
pub(crate) struct ImageFinder<'a> {
    pub split: &'a SplitMesh,
    pub topology: &'a Topology,
    pub attributes: &'a Attributes,
    pub normals: &'a [[f32; 3]],
    /// Whether stand-ins may be made.
    pub stand_ins: bool,
}

impl ImageFinder<'_> {
    /// Writes the image of each variant at the centre of `fan` at `t` to `moved`, by variant.
    pub fn find(&self, fan: &Fan, t: u32, moved: &mut Vec<Moved>) {
        moved.clear();
        for &variant in &fan.variants {
            let image = self.image(variant, fan, t);
            let cost = match image {
                Image::Variant(image) => self.attributes.move_cost(variant, t, image),
                Image::StandIn { uv_of, normal_of, .. } => {
                    self.attributes.move_cost_mixed(variant, t, uv_of, normal_of)
                }
            };
            moved.push(Moved { variant, image, cost });
        }
    }

    fn image(&self, variant: u32, fan: &Fan, t: u32) -> Image {
        let wedge = self.split.variant_wedge[variant as usize];
        let own = Image::StandIn { wedge: None, uv_of: variant, normal_of: variant };
        // Across triangles on the edge.
        let mut direct: Option<u32> = None;
        let mut wedge_image: Option<u32> = None;
        let mut several = false;
        for (there, image) in fan.variants_on_edge(t) {
            if self.split.variant_wedge[there as usize] != wedge {
                continue;
            }
            let image_wedge = self.split.variant_wedge[image as usize];
            several |= wedge_image.is_some_and(|w| w != image_wedge);
            wedge_image = wedge_image.or(Some(image_wedge));
            if there == variant && direct.is_none_or(|d| self.is_closer(variant, image, d)) {
                direct = Some(image);
            }
        }
        // Only where a triangle with this variant stays.
        if several && fan.blades.iter().any(|blade| blade.variants[0] == variant && !blade.touches(t)) {
            return self.cheapest_of_several(variant, fan, t, own);
        }
        if let Some(image) = direct {
            return Image::Variant(image);
        }
        let candidates = || self.topology.around(t).take(SEARCHED_TRIANGLES).map(|triangle| self.at(triangle, t));
        if let Some(image_wedge) = wedge_image {
            let in_wedge = candidates().filter(|&c| self.split.variant_wedge[c as usize] == image_wedge);
            let closest = self.closest(variant, in_wedge).expect("the wedge was found in a triangle at the target");
            if !self.stand_ins || self.cos(variant, closest) >= NORMAL_SPLIT_COS {
                return Image::Variant(closest);
            }
            return Image::StandIn { wedge: Some(image_wedge), uv_of: closest, normal_of: variant };
        }
        let alike = candidates().filter(|&c| self.shows_alike(variant, c));
        match self.closest(variant, alike) {
            Some(image) if self.cos(variant, image) >= NORMAL_SPLIT_COS => Image::Variant(image),
            _ => own,
        }
    }

    /// A slit's end that moves along its slit has an image on either side: whichever costs less, or its own coordinate.
    fn cheapest_of_several(&self, variant: u32, fan: &Fan, t: u32, own: Image) -> Image {
        let wedge = self.split.variant_wedge[variant as usize];
        let mut best = (self.attributes.move_cost(variant, t, variant), own);
        for (there, image) in fan.variants_on_edge(t) {
            if self.split.variant_wedge[there as usize] == wedge {
                let cost = self.attributes.move_cost(variant, t, image);
                if cost < best.0 {
                    best = (cost, Image::Variant(image));
                }
            }
        }
        best.1
    }

    /// Of some variants, the one whose normal is closest to that of `v`.
    pub fn closest(&self, v: u32, candidates: impl Iterator<Item = u32>) -> Option<u32> {
        let mut best: Option<u32> = None;
        for candidate in candidates {
            if best.is_none_or(|b| self.is_closer(v, candidate, b)) {
                best = Some(candidate);
            }
        }
        best
    }

    fn is_closer(&self, v: u32, candidate: u32, best: u32) -> bool {
        if candidate == best {
            return false;
        }
        let (cos, best_cos) = (self.cos(v, candidate), self.cos(v, best));
        cos > best_cos || (cos == best_cos && candidate < best)
    }

    fn cos(&self, a: u32, b: u32) -> f32 {
        cos_between(self.normals[a as usize], self.normals[b as usize])
    }

    fn shows_alike(&self, a: u32, b: u32) -> bool {
        let (a, b) = (a as usize, b as usize);
        let (uv_a, uv_b) = (self.split.variant_uv[a], self.split.variant_uv[b]);
        let (du, dv) = (uv_a[0] - uv_b[0], uv_a[1] - uv_b[1]);
        self.split.variant_material[a] == self.split.variant_material[b]
            && self.split.variant_color[a] == self.split.variant_color[b]
            && du * du + dv * dv <= SAME_UV_SQUARED
    }

    fn at(&self, triangle: u32, p: u32) -> u32 {
        self.topology.triangles[triangle as usize][self.topology.corner_at(triangle, p)]
    }
}
