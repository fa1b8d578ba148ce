//! What a collapse does to texture coordinates, normals and colours: Hoppe 1999's attribute quadrics, one for each variant.
//!
//! Over each triangle an attribute is a linear field of the place in bind pose. Where a corner moves, the field it had there says
//! what the surface showed; the difference to what the new corner shows, squared and weighted by area, is the cost.

use crate::criteria::uv_area;
use crate::lists::Lists;
use crate::split_seams::SplitMesh;
use crate::{AttributeWeights, LodMesh};
use rayon::prelude::*;

/// What a difference of 1 in a normal costs, as a distance, in shares of the mesh's diagonal.
const NORMAL_SHARE: f64 = 0.007;
/// What the difference between black and white costs, as a distance, in shares of the mesh's diagonal.
pub(crate) const COLOR_SHARE: f64 = 0.01;
/// What a slide of the texture costs, as a share of the same distance in space, where the texture is not known.
const SLIDE_SHARE: f64 = 0.1;
/// The same where the texture is known to be plain.
const PLAIN_SLIDE_SHARE: f64 = 0.02;
/// A triangle whose height is below this share of its longest side has no gradient worth the name.
const MIN_HEIGHT_SHARE: f64 = 1.0e-3;

/// Sum over triangles of the squared difference between a linear field with `N` channels and a value: with `x` a place and `s` a
/// value, `weight * |s|² - 2 s·(G x + D) + x·GG x + 2 gd·x + dd`.
#[derive(Debug, Clone, Copy)]
struct Field<const N: usize> {
    gg: [f64; 6],
    gd: [f64; 3],
    dd: f64,
    g: [[f64; 3]; N],
    d: [f64; N],
    weight: f64,
}

impl<const N: usize> Field<N> {
    const ZERO: Self = Self { gg: [0.0; 6], gd: [0.0; 3], dd: 0.0, g: [[0.0; 3]; N], d: [0.0; N], weight: 0.0 };

    /// Adds a triangle's field; `span`: what turns differences along its sides into a gradient.
    fn add(&mut self, span: &Span, values: [[f64; N]; 3], weight: f64) {
        self.weight += weight;
        for k in 0..N {
            let (along_e, along_f) = (values[1][k] - values[0][k], values[2][k] - values[0][k]);
            let g = [0, 1, 2].map(|i| span.dual_e[i] * along_e + span.dual_f[i] * along_f);
            let d = if span.flat {
                (values[0][k] + values[1][k] + values[2][k]) / 3.0
            } else {
                values[0][k] - dot(g, span.origin)
            };
            let products = [g[0] * g[0], g[0] * g[1], g[0] * g[2], g[1] * g[1], g[1] * g[2], g[2] * g[2]];
            for (sum, product) in self.gg.iter_mut().zip(products) {
                *sum += weight * product;
            }
            for i in 0..3 {
                self.gd[i] += weight * g[i] * d;
                self.g[k][i] += weight * g[i];
            }
            self.dd += weight * d * d;
            self.d[k] += weight * d;
        }
    }

    fn merge(&mut self, other: &Self) {
        self.weight += other.weight;
        self.dd += other.dd;
        for i in 0..6 {
            self.gg[i] += other.gg[i];
        }
        for i in 0..3 {
            self.gd[i] += other.gd[i];
        }
        for k in 0..N {
            self.d[k] += other.d[k];
            for i in 0..3 {
                self.g[k][i] += other.g[k][i];
            }
        }
    }

    fn cost(&self, [x, y, z]: [f64; 3], value: [f64; N]) -> f64 {
        let q = &self.gg;
        let mut cost = x * (q[0] * x + 2.0 * (q[1] * y + q[2] * z + self.gd[0]))
            + y * (q[3] * y + 2.0 * (q[4] * z + self.gd[1]))
            + z * (q[5] * z + 2.0 * self.gd[2])
            + self.dd;
        for k in 0..N {
            let shown = self.g[k][0] * x + self.g[k][1] * y + self.g[k][2] * z + self.d[k];
            cost += value[k] * (self.weight * value[k] - 2.0 * shown);
        }
        cost.max(0.0)
    }
}

/// A triangle's dual basis: `dual_e` and `dual_f` lie in its plane, one along each side and square to the other.
struct Span {
    origin: [f64; 3],
    dual_e: [f64; 3],
    dual_f: [f64; 3],
    area: f64,
    flat: bool,
}

impl Span {
    fn new([a, b, c]: [[f64; 3]; 3]) -> Self {
        let (e, f) = (sub(b, a), sub(c, a));
        let (ee, ef, ff) = (dot(e, e), dot(e, f), dot(f, f));
        let determinant = (ee * ff - ef * ef).max(0.0);
        let longest = ee.max(ff).max(ee + ff - 2.0 * ef);
        let flat = determinant <= MIN_HEIGHT_SHARE * MIN_HEIGHT_SHARE * longest * longest;
        let inverse = if flat { 0.0 } else { 1.0 / determinant };
        Self {
            origin: a,
            dual_e: [0, 1, 2].map(|i| (ff * e[i] - ef * f[i]) * inverse),
            dual_f: [0, 1, 2].map(|i| (ee * f[i] - ef * e[i]) * inverse),
            area: determinant.sqrt() * 0.5,
            flat,
        }
    }
}

/// What a vertex shows, each channel in units such that a difference of 1 costs its area.
#[derive(Debug, Clone, Copy)]
struct Shown {
    uv: [f64; 2],
    normal: [f64; 3],
    color: [f64; 3],
}

#[derive(Debug, Clone, Copy)]
struct VariantFields {
    uv: Field<2>,
    normal: Field<3>,
}

impl VariantFields {
    const ZERO: Self = Self { uv: Field::ZERO, normal: Field::ZERO };
}

/// Attribute quadrics of all variants.
#[derive(Debug)]
pub(crate) struct Attributes {
    fields: Vec<VariantFields>,
    /// Those of the colours; empty where no two differ.
    color_fields: Vec<Field<3>>,
    shown: Vec<Shown>,
    /// Bind-space place of each position.
    places: Vec<[f64; 3]>,
    /// Whether any vertex colour differs from another.
    colored: bool,
    normal_weight: f64,
    color_weight: f64,
    /// Position of each variant.
    positions: Vec<u32>,
    /// What each variant's quadric costs where it is.
    paid: Vec<f64>,
}

impl Attributes {
    /// Gathers the fields around each variant. `diagonal`: of the box around the mesh in bind pose, metres.
    pub fn build(mesh: &LodMesh<'_>, split: &SplitMesh, weights: &AttributeWeights, diagonal: f32) -> Self {
        let diagonal = f64::from(diagonal);
        let normal_weight = f64::from(weights.normal) * NORMAL_SHARE * diagonal;
        let color_weight = f64::from(weights.color) * COLOR_SHARE * diagonal;
        let colored = mesh.colors.windows(2).any(|pair| pair[0] != pair[1]);
        let places: Vec<[f64; 3]> =
            split.position_source.iter().map(|&v| mesh.positions[v as usize].map(f64::from)).collect();
        let shown: Vec<Shown> =
            split.variant_source.iter().map(|&v| show(mesh, v, v, normal_weight, color_weight)).collect();
        let spans: Vec<Span> =
            split.triangles.par_iter().map(|t| Span::new(t.map(|v| places[split.position_of(v) as usize]))).collect();
        let slides = slide_squared(mesh, split, &spans, f64::from(weights.uv), diagonal);
        let incident = Lists::incident(shown.len(), split.triangles.iter().copied());
        let gather = |v: usize| {
            let mut field = VariantFields::ZERO;
            for &t in incident.at(v) {
                let (span, values) = (&spans[t as usize], split.triangles[t as usize].map(|v| shown[v as usize]));
                field.uv.add(span, values.map(|s| s.uv), span.area * slides[t as usize]);
                field.normal.add(span, values.map(|s| s.normal), span.area);
            }
            field
        };
        let fields = (0..shown.len()).into_par_iter().map(gather).collect();
        let gather_color = |v: usize| {
            let mut field = Field::ZERO;
            for &t in incident.at(v) {
                let span = &spans[t as usize];
                field.add(span, split.triangles[t as usize].map(|v| shown[v as usize].color), span.area);
            }
            field
        };
        let colored_count = if colored { shown.len() } else { 0 };
        let color_fields = (0..colored_count).into_par_iter().map(gather_color).collect();
        let mut attributes = Self {
            fields,
            color_fields,
            shown,
            places,
            colored,
            normal_weight,
            color_weight,
            paid: Vec::new(),
            positions: Vec::new(),
        };
        attributes.positions = (0..split.variant_wedge.len() as u32).map(|v| split.position_of(v)).collect();
        attributes.paid =
            (0..attributes.shown.len() as u32).into_par_iter().map(|v| attributes.cost_at_home(v)).collect();
        attributes
    }

    /// What it costs that variant `v` moves to position `t` and shows there what `image` shows.
    pub fn move_cost(&self, v: u32, t: u32, image: u32) -> f64 {
        self.cost_of(v, self.places[t as usize], self.shown[image as usize])
    }

    /// The same, showing the texture coordinates and colour of one variant and the normal of another.
    pub fn move_cost_mixed(&self, v: u32, t: u32, uv_of: u32, normal_of: u32) -> f64 {
        let shown = Shown { normal: self.shown[normal_of as usize].normal, ..self.shown[uv_of as usize] };
        self.cost_of(v, self.places[t as usize], shown)
    }

    /// What `v`'s quadric costs where it is.
    pub fn paid(&self, v: u32) -> f64 {
        self.paid[v as usize]
    }

    fn cost_at_home(&self, v: u32) -> f64 {
        self.cost_of(v, self.places[self.positions[v as usize] as usize], self.shown[v as usize])
    }

    /// Adds `v`'s quadric to that of its image, at the image's place.
    pub fn merge(&mut self, v: u32, image: u32) {
        let source = self.fields[v as usize];
        let target = &mut self.fields[image as usize];
        target.uv.merge(&source.uv);
        target.normal.merge(&source.normal);
        if self.colored {
            let source = self.color_fields[v as usize];
            self.color_fields[image as usize].merge(&source);
        }
        self.paid[image as usize] = self.cost_at_home(image);
    }

    /// A new variant at a position, showing what two others show, without triangles of its own yet.
    pub fn add_stand_in(&mut self, position: u32, uv_of: u32, normal_of: u32) {
        self.positions.push(position);
        self.paid.push(0.0);
        let shown = Shown { normal: self.shown[normal_of as usize].normal, ..self.shown[uv_of as usize] };
        self.shown.push(shown);
        self.fields.push(VariantFields::ZERO);
        if self.colored {
            self.color_fields.push(Field::ZERO);
        }
    }

    fn cost_of(&self, v: u32, place: [f64; 3], shown: Shown) -> f64 {
        let field = &self.fields[v as usize];
        let mut cost = field.uv.cost(place, shown.uv);
        if self.normal_weight > 0.0 {
            cost += field.normal.cost(place, shown.normal);
        }
        if self.colored && self.color_weight > 0.0 {
            cost += self.color_fields[v as usize].cost(place, shown.color);
        }
        cost
    }
}

fn show(mesh: &LodMesh<'_>, v: u32, normal_of: u32, normal_weight: f64, color_weight: f64) -> Shown {
    let color = mesh.colors[v as usize];
    Shown {
        uv: mesh.uvs[v as usize].map(f64::from),
        normal: mesh.normals[normal_of as usize].map(|n| f64::from(n) * normal_weight),
        color: [0, 1, 2].map(|i| f64::from(color[i]) / 255.0 * color_weight),
    }
}

/// For each triangle, (metres per unit of texture coordinate)²: what a slide of the texture costs there.
///
/// Where the caller knows the texture, a slide costs as much as the colours change, and a little more, so that a pattern does not
/// drift over the plain; else it costs a share of the way it slides.
fn slide_squared(mesh: &LodMesh<'_>, split: &SplitMesh, spans: &[Span], uv_weight: f64, diagonal: f64) -> Vec<f64> {
    // Metres per unit over the whole mesh: single triangles of a palette texture are dots in it.
    let (mut area, mut area_in_texture) = (0.0, 0.0);
    for (triangle, span) in split.triangles.iter().zip(spans) {
        let corners = triangle.map(|v| mesh.uvs[split.variant_source[v as usize] as usize].map(f64::from));
        area_in_texture += 0.5 * uv_area(corners).abs();
        area += span.area;
    }
    let metres_squared = if area_in_texture > 0.0 { area / area_in_texture } else { 0.0 };
    let contrast = mesh.appearance.triangle_contrast;
    let slide = |t: &u32| match contrast.get(*t as usize) {
        None => metres_squared * SLIDE_SHARE * SLIDE_SHARE,
        Some(&contrast) => {
            let metres = f64::from(contrast) * COLOR_SHARE * diagonal;
            metres * metres + metres_squared * PLAIN_SLIDE_SHARE * PLAIN_SLIDE_SHARE
        }
    };
    split.triangle_source.iter().map(|t| uv_weight * uv_weight * slide(t)).collect()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
