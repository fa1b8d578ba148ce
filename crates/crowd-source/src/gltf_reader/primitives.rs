//! Mesh primitives as plain triangles with checked attributes, still in the mesh's own space.

use gltf::json::Root;
use gltf::json::accessor::ComponentType::{F32, I8, I16, U8, U16, U32};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessors::{Elements, open_accessor};
use super::buffers::Buffers;
use super::document::{DRACO_REMEDY, describe};
use super::influences::{Influence, keep_four_strongest};
use super::materials::TextureUse;
use crate::Result;
use crate::names::{name_or, shorten};
use crate::part::{DEGENERATE, NO_UV, is_uv};
use crate::refusal::{Asset, Warnings};

/// Names of the attributes that are not looked at. Tangents are not among them: they follow from what is.
fn ignored_attributes(primitive: &Primitive, texture: TextureUse) -> Vec<String> {
    let name = |semantic: &Checked<Semantic>| match semantic {
        Checked::Valid(Semantic::Positions | Semantic::Normals | Semantic::Tangents | Semantic::Colors(0)) => None,
        Checked::Valid(Semantic::TexCoords(set)) => (*set != texture.uv_set).then(|| format!("TEXCOORD_{set}")),
        // What is left over of these is counted where the strongest four are kept.
        Checked::Valid(Semantic::Joints(_) | Semantic::Weights(_)) => None,
        Checked::Valid(Semantic::Colors(set)) => Some(format!("COLOR_{set}")),
        Checked::Valid(Semantic::Extras(own)) => Some(shorten(&format!("_{own}"))),
        Checked::Invalid => Some("attributes of unknown names".to_owned()),
    };
    primitive.attributes.keys().filter_map(name).collect()
}

/// JOINTS_n and WEIGHTS_n that are looked at: 32 influences a vertex, of which four stay. Bounds memory.
const INFLUENCE_SETS: u32 = 8;

/// A primitive as read: per-vertex arrays of equal length, triangles within them.
pub(super) struct Shape {
    pub(super) place: String,
    pub(super) name: String,
    pub(super) material: Option<usize>,
    pub(super) positions: Vec<[f32; 3]>,
    /// Empty where the file has none.
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) colors: Vec<[u8; 4]>,
    /// Empty where the primitive has no joints.
    pub(super) influences: Vec<Influence>,
    /// How many JOINTS_n there are.
    pub(super) joint_sets: u32,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) morph_targets: u64,
}

/// What reading primitives needs to look at, and counts so far.
pub(super) struct Geometry<'a, 'b> {
    pub(super) asset: Asset<'a>,
    pub(super) root: &'a Root,
    pub(super) buffers: &'a Buffers<'b>,
    /// Vertices and triangles read so far, over all primitives.
    pub(super) vertices_read: u64,
    pub(super) triangles_read: u64,
    /// Triangles left out because they use one vertex twice.
    pub(super) degenerate: u64,
    /// Primitives of points and lines, left out.
    pub(super) skipped: u64,
}

impl<'a> Geometry<'a, '_> {
    /// Reads all primitives of a mesh that are made of triangles.
    pub(super) fn read_mesh(
        &mut self,
        index: usize,
        textures: &[TextureUse],
        warnings: &mut Warnings,
    ) -> Result<Vec<Shape>> {
        let Some(mesh) = self.root.meshes.get(index) else {
            let problem = format!("mesh {index}, the file has {}", self.root.meshes.len());
            return Err(self.asset.format("nodes", problem));
        };
        let mesh_place = describe("mesh", index, mesh.name.as_ref());
        let mut shapes = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("{mesh_place} primitive {number}");
            let name = name_or(mesh.name.as_deref(), || format!("mesh {index}"));
            shapes.extend(self.read_primitive(place, name, primitive, textures, warnings)?);
        }
        Ok(shapes)
    }

    fn read_primitive(
        &mut self,
        place: String,
        name: String,
        primitive: &Primitive,
        textures: &[TextureUse],
        warnings: &mut Warnings,
    ) -> Result<Option<Shape>> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err(self.asset.format(place, "`mode` is none of 0 to 6"));
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            let message = format!("{mode:?} are no surface and were left out; convert them to triangles to keep them");
            warnings.add("points-and-lines-skipped", &place, 1, message);
            self.skipped += 1;
            return Ok(None);
        }
        let material = primitive.material.map(|m| m.value());
        let texture = match material {
            None => TextureUse::default(),
            Some(m) => *textures
                .get(m)
                .ok_or_else(|| self.asset.format(&place, format!("material {m}, the file has {}", textures.len())))?,
        };
        self.refuse_draco(&place, primitive)?;
        let ignored = ignored_attributes(primitive, texture);
        let message = format!("{}: nothing here reads them, and exports will not have them", ignored.join(", "));
        warnings.add("attributes-ignored", &place, ignored.len() as u64, message);
        let Some(elements) = self.open(&place, primitive, Semantic::Positions)? else {
            return Err(self.asset.format(place, "no POSITION"));
        };
        elements.expect(&[3], &[F32, I8, U8, I16, U16])?;
        let count = elements.count;
        self.vertices_read += count as u64;
        self.asset.check_limit(&place, "vertices", self.vertices_read, self.asset.limits.vertices)?;
        let positions = to_vectors::<3>(&elements.read_floats(elements.normalized)?);
        if let Some(v) = positions.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            let problem = format!("POSITION: vertex {v} is {:?}; positions are finite", positions[v]);
            return Err(self.asset.format(place, problem));
        }
        let indices = self.read_indices(&place, primitive, count)?;
        if mode == Mode::Triangles {
            let left_over = indices.len() as u64 % 3;
            warnings.add("incomplete-triangles", &place, left_over, "indices left over after the last whole triangle");
        }
        let (triangles, degenerate) = unroll_triangles(mode, &indices);
        self.triangles_read += triangles.len() as u64 + degenerate;
        self.degenerate += degenerate;
        self.asset.check_limit(&place, "triangles", self.triangles_read, self.asset.limits.triangles)?;
        if mode == Mode::Triangles {
            warnings.add("degenerate-triangles-dropped", &place, degenerate, DEGENERATE);
        }
        if triangles.is_empty() {
            warnings.add("empty-primitive", &place, 1, "the primitive has no triangles");
            return Ok(None);
        }
        let normals = match self.open(&place, primitive, Semantic::Normals)? {
            None => Vec::new(),
            Some(elements) => {
                elements.expect(&[3], &[F32, I8, I16])?;
                self.check_count(&place, "NORMAL", elements.count, count)?;
                to_vectors::<3>(&elements.read_floats(true)?)
            }
        };
        let uvs = self.read_uvs(&place, primitive, count, texture, warnings)?;
        let colors = self.read_colors(&place, primitive, count)?;
        let (influences, joint_sets) = self.read_influences(&place, primitive, count, warnings)?;
        let morph_targets = primitive.targets.as_ref().map_or(0, |t| t.len() as u64);
        Ok(Some(Shape {
            place,
            name,
            material,
            positions,
            normals,
            uvs,
            colors,
            influences,
            joint_sets,
            triangles,
            morph_targets,
        }))
    }

    /// Some files use Draco without requiring it, and without the plain data that would make it optional.
    fn refuse_draco(&self, place: &str, primitive: &Primitive) -> Result<()> {
        let compressed =
            primitive.extensions.as_ref().is_some_and(|e| e.others.contains_key("KHR_draco_mesh_compression"));
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let plain = positions
            .and_then(|p| self.root.accessors.get(p.value()))
            .is_some_and(|accessor| accessor.buffer_view.is_some());
        if !compressed || plain {
            return Ok(());
        }
        Err(self.asset.unsupported(place, "the extension KHR_draco_mesh_compression", DRACO_REMEDY))
    }

    fn open(&self, place: &str, primitive: &Primitive, semantic: Semantic) -> Result<Option<Elements<'a>>> {
        let place = format!("{place}: {}", semantic.to_string());
        let Some(accessor) = primitive.attributes.get(&Checked::Valid(semantic)) else { return Ok(None) };
        let allowed = ("vertices", self.asset.limits.vertices);
        open_accessor(self.asset, self.root, self.buffers, &place, accessor.value(), allowed).map(Some)
    }

    fn check_count(&self, place: &str, what: &str, found: usize, vertices: usize) -> Result<()> {
        if found == vertices {
            return Ok(());
        }
        Err(self.asset.format(place, format!("{what} has {found} elements, POSITION has {vertices}")))
    }

    fn read_indices(&self, place: &str, primitive: &Primitive, vertices: usize) -> Result<Vec<u32>> {
        let Some(accessor) = primitive.indices else { return Ok((0..vertices as u32).collect()) };
        let place = format!("{place}: indices");
        let allowed = ("indices", self.asset.limits.triangles.saturating_mul(3));
        let elements = open_accessor(self.asset, self.root, self.buffers, &place, accessor.value(), allowed)?;
        elements.expect(&[1], &[U8, U16, U32])?;
        let indices = elements.read_integers()?;
        if let Some(i) = indices.iter().position(|i| *i as usize >= vertices) {
            let problem = format!("index {i} is vertex {}, the primitive has {vertices} vertices", indices[i]);
            return Err(self.asset.format(place, problem));
        }
        Ok(indices)
    }

    fn read_uvs(
        &self,
        place: &str,
        primitive: &Primitive,
        vertices: usize,
        texture: TextureUse,
        warnings: &mut Warnings,
    ) -> Result<Vec<[f32; 2]>> {
        let set = texture.uv_set;
        let Some(elements) = self.open(place, primitive, Semantic::TexCoords(set))? else {
            if texture.textured {
                let message = format!("the material's texture uses TEXCOORD_{set}, which is missing; zeros were used");
                warnings.add("uvs-missing", place, 1, message);
            }
            return Ok(vec![[0.0; 2]; vertices]);
        };
        elements.expect(&[2], &[F32, U8, U16, I8, I16])?;
        self.check_count(place, &format!("TEXCOORD_{set}"), elements.count, vertices)?;
        let mut uvs = to_vectors::<2>(&elements.read_floats(elements.normalized)?);
        let mut repaired = 0;
        for uv in &mut uvs {
            *uv = texture.apply(*uv);
            if !is_uv(uv) {
                *uv = [0.0; 2];
                repaired += 1;
            }
        }
        warnings.add("uvs-repaired", place, repaired, NO_UV);
        Ok(uvs)
    }

    /// Linear RGBA8; white where the file has none.
    fn read_colors(&self, place: &str, primitive: &Primitive, vertices: usize) -> Result<Vec<[u8; 4]>> {
        let Some(elements) = self.open(place, primitive, Semantic::Colors(0))? else {
            return Ok(vec![[255; 4]; vertices]);
        };
        elements.expect(&[3, 4], &[F32, U8, U16])?;
        self.check_count(place, "COLOR_0", elements.count, vertices)?;
        // Integers are always normalised here; some files forget to say so.
        let numbers = elements.read_floats(true)?;
        // NaN becomes 0 in the cast.
        let quantize = |c: f32| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let colors = numbers.chunks_exact(elements.width).map(|c| {
            let alpha = if elements.width == 4 { c[3] } else { 1.0 };
            [c[0], c[1], c[2], alpha].map(quantize)
        });
        Ok(colors.collect())
    }

    fn read_influences(
        &self,
        place: &str,
        primitive: &Primitive,
        vertices: usize,
        warnings: &mut Warnings,
    ) -> Result<(Vec<Influence>, u32)> {
        let mut sets = Vec::new();
        for set in 0..INFLUENCE_SETS {
            let Some(joints) = self.open(place, primitive, Semantic::Joints(set))? else { break };
            joints.expect(&[4], &[U8, U16])?;
            self.check_count(place, &format!("JOINTS_{set}"), joints.count, vertices)?;
            let Some(weights) = self.open(place, primitive, Semantic::Weights(set))? else {
                return Err(self.asset.format(place, format!("JOINTS_{set} without WEIGHTS_{set}")));
            };
            weights.expect(&[4], &[F32, U8, U16])?;
            self.check_count(place, &format!("WEIGHTS_{set}"), weights.count, vertices)?;
            let weights = weights.read_floats(true)?;
            if let Some(w) = weights.iter().position(|w| !w.is_finite()) {
                let problem = format!("WEIGHTS_{set}: vertex {} has weight {}", w / 4, weights[w]);
                return Err(self.asset.format(place, problem));
            }
            sets.push((joints.read_integers()?, weights));
        }
        if sets.is_empty() {
            return Ok((Vec::new(), 0));
        }
        Ok((keep_four_strongest(place, vertices, &sets, warnings), sets.len() as u32))
    }
}

fn to_vectors<const N: usize>(numbers: &[f32]) -> Vec<[f32; N]> {
    numbers.chunks_exact(N).map(|c| std::array::from_fn(|i| c[i])).collect()
}

/// Triangles out of a list, strip or fan (glTF 2.0 §3.7.2.1), without those that use one vertex twice; and their count.
fn unroll_triangles(mode: Mode, indices: &[u32]) -> (Vec<[u32; 3]>, u64) {
    let count = indices.len();
    let all: Vec<[u32; 3]> = match mode {
        Mode::TriangleStrip => {
            (0..count.saturating_sub(2)).map(|i| [indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]]).collect()
        }
        Mode::TriangleFan => (1..count.saturating_sub(1)).map(|i| [indices[i], indices[i + 1], indices[0]]).collect(),
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    };
    let found = all.len();
    let kept: Vec<[u32; 3]> = all.into_iter().filter(|[a, b, c]| a != b && b != c && a != c).collect();
    let dropped = (found - kept.len()) as u64;
    (kept, dropped)
}
