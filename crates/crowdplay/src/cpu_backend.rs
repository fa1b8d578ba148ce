//! Frames drawn by the software rasteriser: the stages' CPU twins, posing in parallel, one batch at a time.

use crate::cpu_levels::CpuLevels;
use crate::crowd::Crowd;
use crate::picture::Picture;
use crate::scenery::Scenery;
use crate::{Error, Result};
use crowd_pack::{CharacterRecord, MaterialRecord, NONE, VertexRecord, material_flags};
use crowd_raster::{Batch, Dab, Fill, Material, Mip, Target, Texture, View, Wrap};
use crowd_stages::{CrowdData, DrawOptions, FrameConfig, FrameTotals, InstanceRecord, LodChoice, cpu};
use glam::{Mat4, Vec3};
use rayon::prelude::*;
use std::time::Instant;

/// Vertices posed before they are drawn: bounds the memory of a frame to some tens of megabytes.
const BATCH_VERTICES: usize = 1 << 18;
/// Pixels of a picture, supersamples counted: a gigabyte of colour and depth, and as much again until its PNG is written.
const MOST_PIXELS: u64 = 1 << 27;
/// Materials a batch can address with 16 bits.
const BATCH_MATERIALS: usize = 1 << 16;

/// A rasteriser with the crowd's textures.
pub struct CpuBackend {
    textures: Vec<Texture>,
    materials: Vec<Material>,
    levels: CpuLevels,
    /// The newest frame, `factor` times as wide and high as asked for.
    target: Target,
    factor: u32,
    timings_ms: Vec<(&'static str, f32)>,
}

impl CpuBackend {
    /// `samples` 4 draws at twice the width and height and averages.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a size whose picture would not fit into memory comfortably.
    pub fn new(crowd: &Crowd, size: [u32; 2], samples: u32) -> Result<Self> {
        let factor = if samples >= 4 { 2 } else { 1 };
        let pixels = size.map(|side| u64::from(side) * u64::from(factor));
        if pixels[0] * pixels[1] > MOST_PIXELS {
            return Err(Error::Parameter {
                option: "--size",
                found: format!("{}x{} with --msaa {samples}", size[0], size[1]),
                allowed: format!("up to {} pixels on the CPU", MOST_PIXELS / u64::from(factor * factor)),
            });
        }
        let texture = |layer: &crowd_stages::TextureLayer| Texture { mips: mips(layer, crowd.data.layer_side) };
        Ok(Self {
            textures: crowd.data.layers.iter().map(texture).collect(),
            materials: crowd.data.materials.iter().map(material).collect(),
            levels: CpuLevels::new(&crowd.data)?,
            target: Target::new(size[0] * factor, size[1] * factor, [0, 0, 0, 255]),
            factor,
            timings_ms: Vec::new(),
        })
    }

    /// Another picture size.
    pub fn resize(&mut self, size: [u32; 2]) {
        let [width, height] = size.map(|side| side * self.factor);
        if [self.target.width, self.target.height] != [width, height] {
            self.target = Target::new(width, height, [0, 0, 0, 255]);
        }
    }

    /// Draws a frame; tells `watch` now and then which share of its people is drawn.
    pub fn draw(
        &mut self,
        crowd: &Crowd,
        config: &FrameConfig,
        options: DrawOptions,
        watch: &mut dyn FnMut(f64),
    ) -> FrameTotals {
        let start = Instant::now();
        let frame = self.levels.select(crowd, config, options);
        let selected = Instant::now();
        let view = View {
            clip_from_world: Mat4::from_cols_array_2d(&config.clip_from_world),
            eye: Vec3::from_array(config.eye),
        };
        crowd_raster::draw_sky(&mut self.target, &view);
        crowd_raster::draw_ground(&mut self.target, &view);
        draw_scenery(&mut self.target, &view, &crowd.scenery);
        let grounded = Instant::now();
        let mut batch = BatchBuilder::new(crowd.data.characters.len());
        let drawn: Vec<usize> = (0..crowd.instances.len()).filter(|&i| frame.choices[i].triangle_count > 0).collect();
        let mut rest = &drawn[..];
        while !rest.is_empty() {
            let taken = batch.fill(&crowd.data, &crowd.instances, &frame, rest, config.time_s, &self.materials);
            crowd_raster::draw(&mut self.target, &view, &batch.as_batch(&self.textures));
            rest = &rest[taken..];
            watch(1.0 - rest.len() as f64 / drawn.len() as f64);
        }
        self.draw_points(crowd, &frame, &view, config.time_s);
        crowd_raster::draw_fog(&mut self.target, &view, config.fog_per_m);
        let ms = |from: Instant, to: Instant| (to - from).as_secs_f32() * 1e3;
        self.timings_ms = vec![
            ("select", ms(start, selected)),
            ("ground", ms(selected, grounded)),
            ("pose_and_draw", ms(grounded, Instant::now())),
        ];
        frame.totals
    }

    /// Draws those who are points.
    fn draw_points(&mut self, crowd: &Crowd, frame: &cpu::CpuFrame, view: &View, time_s: f32) {
        for (instance, choice) in crowd.instances.iter().zip(&frame.choices) {
            if choice.triangle_count == 0 && choice.vertex_count > 0 {
                let points = self.levels.points(&crowd.data, instance, *choice, time_s);
                crowd_raster::draw_dabs(
                    &mut self.target,
                    view,
                    &points.into_iter().map(dab).collect::<Vec<_>>(),
                    self.factor,
                );
            }
        }
    }

    /// The newest frame's pixels.
    pub fn picture(&self) -> Picture {
        let smaller = (self.factor > 1).then(|| crowd_raster::downsample(&self.target, self.factor));
        let target = smaller.as_ref().unwrap_or(&self.target);
        Picture { width: target.width, height: target.height, pixels: target.color.clone() }
    }

    /// Milliseconds by step of the newest frame.
    pub fn timings_ms(&self) -> Vec<(&'static str, f32)> {
        self.timings_ms.clone()
    }
}

fn dab(point: cpu::PosedPoint) -> Dab {
    let cpu::PosedPoint { position, normal, color, is_unlit, is_double_sided } = point;
    Dab { position, normal, color, is_unlit, is_double_sided }
}

/// Ground and walls: a few triangles, gathered anew each frame.
fn draw_scenery(target: &mut Target, view: &View, scenery: &Scenery) {
    if scenery.triangles.is_empty() {
        return;
    }
    let Scenery { vertices, triangles } = scenery;
    let plain = Material {
        base_color: [1.0; 4],
        texture: None,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        alpha_cutoff: 0.0,
        double_sided: false,
        unlit: false,
        flat: false,
    };
    let positions: Vec<[f32; 3]> = vertices.iter().map(|vertex| vertex.position).collect();
    let normals: Vec<[f32; 3]> = vertices.iter().map(|vertex| vertex.normal).collect();
    let colors: Vec<[u8; 4]> = vertices.iter().map(|vertex| vertex.color).collect();
    let batch = Batch {
        positions: &positions,
        normals: &normals,
        uvs: &vec![[0.0; 2]; vertices.len()],
        colors: &colors,
        vertex_materials: &vec![0; vertices.len()],
        triangles,
        materials: &[plain],
        textures: &[],
        fill: Fill::Shaded,
    };
    crowd_raster::draw(target, view, &batch);
}

/// Several posed instances as one list of triangles. Kept between batches, so that its memory is, too.
struct BatchBuilder {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    colors: Vec<[u8; 4]>,
    vertex_materials: Vec<u16>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<Material>,
    /// Where a character's materials start in this batch.
    material_base: Vec<Option<u16>>,
}

impl BatchBuilder {
    fn new(characters: usize) -> Self {
        Self {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            vertex_materials: Vec::new(),
            triangles: Vec::new(),
            materials: Vec::new(),
            material_base: vec![None; characters],
        }
    }

    /// Poses the first of `drawn` (indices of instances), as many as a batch holds; how many it took, at least one.
    fn fill(
        &mut self,
        data: &CrowdData,
        instances: &[InstanceRecord],
        frame: &cpu::CpuFrame,
        drawn: &[usize],
        time_s: f32,
        materials: &[Material],
    ) -> usize {
        self.clear();
        let choices = &frame.choices;
        let taken = self.admit(data, instances, choices, drawn, materials);
        let drawn = &drawn[..taken];
        let pose = |&i: &usize| match frame.morphs.get(i) {
            Some(morph) => cpu::pose_between(data, &instances[i], choices[i], *morph, time_s),
            None => cpu::pose_instance(data, &instances[i], choices[i], time_s),
        };
        let posed: Vec<cpu::PosedInstance> = drawn.par_iter().map(pose).collect();
        for (&i, posed) in drawn.iter().zip(posed) {
            self.push(data, &data.characters[instances[i].character as usize], instances[i].character, posed);
        }
        taken
    }

    fn clear(&mut self) {
        self.positions.clear();
        self.normals.clear();
        self.uvs.clear();
        self.colors.clear();
        self.vertex_materials.clear();
        self.triangles.clear();
        self.materials.clear();
        self.material_base.fill(None);
    }

    /// Counts how many instances fit, and gives their characters' materials a place.
    fn admit(
        &mut self,
        data: &CrowdData,
        instances: &[InstanceRecord],
        choices: &[LodChoice],
        drawn: &[usize],
        materials: &[Material],
    ) -> usize {
        let mut vertices = 0;
        for (taken, &i) in drawn.iter().enumerate() {
            let character = instances[i].character as usize;
            let record = &data.characters[character];
            vertices += choices[i].vertex_count as usize;
            let is_new = self.material_base[character].is_none();
            let more = if is_new { record.material_count as usize } else { 0 };
            let full = vertices > BATCH_VERTICES || self.materials.len() + more > BATCH_MATERIALS;
            if full && taken > 0 {
                return taken;
            }
            if is_new {
                self.material_base[character] = Some(self.materials.len() as u16);
                let first = record.material_offset as usize;
                self.materials.extend_from_slice(&materials[first..first + record.material_count as usize]);
            }
        }
        drawn.len()
    }

    fn push(&mut self, data: &CrowdData, record: &CharacterRecord, character: u32, posed: cpu::PosedInstance) {
        let base = self.positions.len() as u32;
        let first = record.vertex_offset as usize;
        let level: &[VertexRecord] = &data.vertices[first..first + posed.positions.len()];
        let material_base = self.material_base[character as usize].expect("admit placed every character of the batch");
        self.uvs.extend_from_slice(&posed.uvs);
        self.colors.extend_from_slice(&posed.colors);
        self.vertex_materials.extend(level.iter().map(|v| material_base + (v.material_class & 0xffff) as u16));
        self.triangles.extend(posed.triangles.iter().map(|t| t.map(|corner| base + corner)));
        self.positions.extend_from_slice(&posed.positions);
        self.normals.extend_from_slice(&posed.normals);
    }

    fn as_batch<'a>(&'a self, textures: &'a [Texture]) -> Batch<'a> {
        Batch {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            colors: &self.colors,
            vertex_materials: &self.vertex_materials,
            triangles: &self.triangles,
            materials: &self.materials,
            textures,
            fill: Fill::Shaded,
        }
    }
}

fn material(record: &MaterialRecord) -> Material {
    let wrap = |shift: u32| match (record.flags >> shift) & material_flags::WRAP_MASK {
        1 => Wrap::Clamp,
        2 => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    Material {
        base_color: record.base_color,
        texture: (record.image != NONE).then_some(record.image),
        wrap_u: wrap(material_flags::WRAP_U_SHIFT),
        wrap_v: wrap(material_flags::WRAP_V_SHIFT),
        alpha_cutoff: record.alpha_cutoff,
        double_sided: record.flags & material_flags::DOUBLE_SIDED != 0,
        unlit: record.flags & material_flags::UNLIT != 0,
        flat: record.flags & material_flags::FLAT != 0,
    }
}

fn mips(layer: &crowd_stages::TextureLayer, side: u32) -> Vec<Mip> {
    let mip = |(level, texels): (usize, &Vec<[u8; 4]>)| {
        let side = (side >> level).max(1);
        Mip { width: side, height: side, texels: texels.clone() }
    };
    layer.mips.iter().enumerate().map(mip).collect()
}
