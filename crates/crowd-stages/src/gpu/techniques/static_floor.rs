//! B4: the very triangles that the bucketed technique would draw, placed beforehand: what drawing alone costs.

use super::{FrameContext, Painter, Workshop};
use crate::cpu::{key_instances, pose_between, scan_counts};
use crate::gpu::lit::Lit;
use crate::gpu::stage_recorder::StageRecorder;
use crate::gpu::upload::Uploader;
use crate::{
    Buckets, CrowdData, CullRecord, FillState, FrameConfig, FrameTotals, InstanceRecord, LodChoice, MorphRecord, Result,
};
use bytemuck::{Pod, Zeroable};
use crowd_pack::encode_normal;
use rayon::prelude::*;
use wgpu::BufferUsages as Usage;

/// A vertex where it stands in the world, 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct FloorVertex {
    position: [f32; 3],
    normal_oct: u32,
    uv: [f32; 2],
    color: u32,
    material: u32,
}

/// One mesh with everyone in it.
pub(crate) struct Floor {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    totals: FrameTotals,
}

impl Floor {
    /// Places every instance at its level and time. Indices are those of the level's table.
    pub(crate) fn bake(
        up: &mut Uploader<'_>,
        data: &CrowdData,
        instances: &[InstanceRecord],
        culled: &[CullRecord],
        choices: &[LodChoice],
        fill: &FillState,
        config: &FrameConfig,
    ) -> Result<Self> {
        let buckets = Buckets::of(data)?;
        let (_, morphs) = key_instances(&buckets, instances, culled, choices, fill, config);
        let (bases, end) = scan_counts(choices);
        let drawn: Vec<usize> = (0..choices.len()).filter(|i| choices[*i].vertex_count > 0).collect();
        let vertices: Vec<Vec<FloorVertex>> =
            drawn.par_iter().map(|i| place(data, &instances[*i], choices[*i], morphs[*i], config.time_s)).collect();
        let corners = drawn.iter().flat_map(|i| {
            let bucket = buckets.fitting(instances[*i].character, choices[*i].vertex_count);
            let base = bases[*i].vertex_base;
            buckets.triangles(bucket).into_iter().flatten().map(move |corner| base + corner)
        });
        let indices: Vec<u32> = corners.collect();
        let smaller = "lower the vertex budget";
        let totals = FrameTotals {
            visible_count: drawn.len() as u32,
            outside_count: (instances.len() - drawn.len()) as u32,
            vertex_count: end.vertex_base,
            triangle_count: indices.len() as u32 / 3,
            needed_vertices: end.vertex_base,
            needed_triangles: indices.len() as u32 / 3,
            draw_count: u32::from(!indices.is_empty()),
            ..Default::default()
        };
        Ok(Self {
            vertices: up.filled("bytes of placed vertices", &vertices.concat(), Usage::VERTEX, smaller)?,
            indices: up.filled("bytes of the floor's indices", &indices, Usage::INDEX, smaller)?,
            totals,
        })
    }
}

fn place(
    data: &CrowdData,
    instance: &InstanceRecord,
    choice: LodChoice,
    morph: MorphRecord,
    time_s: f32,
) -> Vec<FloorVertex> {
    let character = &data.characters[instance.character as usize];
    let posed = pose_between(data, instance, choice, morph, time_s);
    let records = &data.vertices[character.vertex_offset as usize..][..choice.vertex_count as usize];
    let vertex = |(v, record): (usize, &crowd_pack::VertexRecord)| FloorVertex {
        position: posed.positions[v],
        normal_oct: encode_normal(posed.normals[v]),
        uv: posed.uvs[v],
        color: u32::from_le_bytes(posed.colors[v]),
        material: character.material_offset + (record.material_class & 0xffff),
    };
    records.iter().enumerate().map(vertex).collect()
}

const ATTRIBUTES: [wgpu::VertexAttribute; 5] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32, 2 => Float32x2, 3 => Unorm8x4, 4 => Uint32];

/// Draws a floor once it has one.
pub(crate) struct StaticFloor {
    pipeline: Lit,
    bound: wgpu::BindGroup,
    floor: Option<Floor>,
}

impl StaticFloor {
    pub(crate) fn new(workshop: Workshop<'_, '_>) -> Self {
        let Workshop { crowd, frame, draw, .. } = workshop;
        let layout = wgpu::VertexBufferLayout {
            array_stride: size_of::<FloorVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &ATTRIBUTES,
        };
        Self {
            pipeline: draw.pipeline_with("placed", &[Some(layout)]),
            bound: draw.bind(crowd, frame, &frame.choices, &frame.nothing),
            floor: None,
        }
    }
}

impl Painter for StaticFloor {
    fn record_stages(&self, _: &mut StageRecorder<'_>, _: &FrameContext<'_>) {}

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, context: &FrameContext<'_>) {
        let Some(floor) = self.floor.as_ref().filter(|floor| floor.totals.triangle_count > 0) else { return };
        pass.set_pipeline(self.pipeline.of(context.options.shadows > 0));
        pass.set_bind_group(0, &self.bound, &[]);
        pass.set_vertex_buffer(0, floor.vertices.slice(..));
        pass.set_index_buffer(floor.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..floor.totals.triangle_count * 3, 0, 0..1);
    }

    fn known_totals(&self, _: &FrameContext<'_>) -> Option<FrameTotals> {
        Some(self.floor.as_ref().map_or(FrameTotals::default(), |floor| floor.totals))
    }

    fn is_ready(&self) -> bool {
        self.floor.is_some()
    }

    fn lay_floor(&mut self, floor: Floor) {
        self.floor = Some(floor);
    }
}
