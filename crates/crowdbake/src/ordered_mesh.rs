//! A character in collapse order, unpacked from its records: what levels are taken from, measured on and refitted to. Whoever
//! bakes and whoever holds a pack gets the same numbers from it.

use crate::appearance::ShownTextures;
use crate::unpack::Unpacked;
use crowd_lod::{Appearance, CollapseOrder, Level, LevelMesh, LodMesh, Surface, VertexClass, reform};
use crowd_pack::{ImageRecord, LodRecord, MaterialRecord, VertexRecord, vertex_class};

/// Vertices unpacked; one entry per vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DecodedVertices {
    /// Bind-space positions, metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// Joint indices.
    pub joints: Vec<[u16; 4]>,
    /// Weights.
    pub weights: Vec<[f32; 4]>,
}

impl DecodedVertices {
    /// Unpacks records.
    pub fn new(records: &[VertexRecord]) -> Self {
        Self {
            positions: records.iter().map(|vertex| vertex.position).collect(),
            normals: records.iter().map(VertexRecord::normal).collect(),
            uvs: records.iter().map(|vertex| vertex.uv).collect(),
            joints: records.iter().map(VertexRecord::joint_indices).collect(),
            weights: records.iter().map(VertexRecord::weights_f32).collect(),
        }
    }

    /// These vertices with triangles.
    pub fn surface<'a>(&'a self, triangles: &'a [[u32; 3]]) -> Surface<'a> {
        Surface {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            joints: &self.joints,
            weights: &self.weights,
            triangles,
        }
    }
}

/// A character in collapse order.
#[derive(Debug, Clone)]
pub struct OrderedMesh {
    /// As stored.
    pub records: Vec<VertexRecord>,
    /// Unpacked.
    pub vertices: DecodedVertices,
    /// Texels of each vertex's texture along u and v; 0 without one.
    pub texels: Vec<[f32; 2]>,
    /// Full-detail triangles, map and levels; each vertex is its own source.
    pub order: CollapseOrder,
    colors: Vec<[u8; 4]>,
    triangle_materials: Vec<u16>,
    textures: Option<ShownTextures>,
}

impl OrderedMesh {
    /// From what a pack holds of a character. `material_texels`: width and height of each material's texture.
    pub fn new(
        records: Vec<VertexRecord>,
        triangles: Vec<[u32; 3]>,
        collapse_map: Vec<u32>,
        levels: Vec<Level>,
        material_texels: &[[f32; 2]],
    ) -> Self {
        let class = |vertex: &VertexRecord| match vertex.class() {
            vertex_class::REGULAR => VertexClass::Regular,
            vertex_class::COMPANION => VertexClass::Companion,
            _ => VertexClass::Fixed,
        };
        let identity: Vec<u32> = (0..records.len() as u32).collect();
        let material = |triangle: &[u32; 3]| records[triangle[0] as usize].material() as u16;
        Self {
            vertices: DecodedVertices::new(&records),
            texels: records.iter().map(|vertex| material_texels[vertex.material() as usize]).collect(),
            colors: records.iter().map(|vertex| vertex.color.to_le_bytes()).collect(),
            triangle_materials: triangles.iter().map(material).collect(),
            textures: None,
            order: CollapseOrder {
                vertex_source: identity.clone(),
                attribute_source: identity.clone(),
                normal_source: identity,
                vertex_materials: records.iter().map(|vertex| vertex.material() as u16).collect(),
                vertex_classes: records.iter().map(class).collect(),
                triangle_source: (0..triangles.len() as u32).collect(),
                triangles,
                collapse_map,
                levels,
                ..CollapseOrder::default()
            },
            records,
        }
    }

    /// With what the textures show, by the order's triangles; without, a refit takes them for plain.
    #[must_use]
    pub(crate) fn with_textures(self, textures: ShownTextures) -> Self {
        Self { textures: Some(textures), ..self }
    }

    /// From a pack.
    pub fn of_pack(character: &Unpacked<'_>) -> Self {
        let mut levels: Vec<LodRecord> = character.lods.to_vec();
        levels.dedup();
        let level =
            |lod: LodRecord| Level { vertex_count: lod.vertex_count, triangle_count: lod.triangle_count, error_m: 0.0 };
        let texels = |material: &MaterialRecord| {
            let image: Option<&ImageRecord> = character.contents.images.get(material.image as usize);
            image.map_or([0.0; 2], |image| [image.width as f32, image.height as f32])
        };
        let material_texels: Vec<[f32; 2]> = character.materials.iter().map(texels).collect();
        Self::new(
            character.vertices.to_vec(),
            character.triangles.to_vec(),
            character.collapse_map.to_vec(),
            levels.into_iter().map(level).collect(),
            &material_texels,
        )
    }

    /// Full detail as a surface.
    pub fn surface(&self) -> Surface<'_> {
        self.vertices.surface(&self.order.triangles)
    }

    /// Full detail as a mesh to simplify or refit to.
    pub fn mesh(&self) -> LodMesh<'_> {
        LodMesh {
            positions: &self.vertices.positions,
            normals: &self.vertices.normals,
            uvs: &self.vertices.uvs,
            colors: &self.colors,
            joints: &self.vertices.joints,
            weights: &self.vertices.weights,
            triangles: &self.order.triangles,
            triangle_materials: &self.triangle_materials,
            appearance: self.textures.as_ref().map_or_else(Appearance::default, ShownTextures::view),
        }
    }

    /// The triangles of a level, in the order's sequence.
    pub fn level_triangles(&self, level: &Level) -> Vec<[u32; 3]> {
        reform(&self.order.triangles, &self.order.collapse_map, level.vertex_count, level.triangle_count)
    }

    /// The vertices of a refitted level as a pack stores them: colour and material are those of the order's vertices, the
    /// class that of the vertex that each stands at.
    pub fn refit_records(&self, level: &LevelMesh) -> Vec<VertexRecord> {
        let record = |(vertex, &ordered): (usize, &u32)| {
            let old = &self.records[ordered as usize];
            let (position, uv, normal) = (level.positions[vertex], level.uvs[vertex], level.normals[vertex]);
            let moved =
                crate::views::quantize_vertex(position, normal, uv, level.joints[vertex], level.weights[vertex]);
            let class = self.records[level.stands_at[vertex] as usize].class();
            let material_class = old.material() | class << 16;
            VertexRecord { color: old.color, material_class, ..moved }
        };
        level.vertices.iter().enumerate().map(record).collect()
    }
}
