//! Which levels a technique draws, worked out on the CPU: for drawing there, and for measuring what levels do.

use crate::Result;
use crate::crowd::Crowd;
use crowd_pack::LodRecord;
use crowd_stages::cpu::PosedPoint;
use crowd_stages::{
    Buckets, CrowdData, DrawOptions, Fit, FrameConfig, InstanceRecord, Levels, LodChoice, MorphRecord, PointRecord,
    Technique, Weight, cpu, is_impostor, surface_points,
};
use std::sync::OnceLock;

/// The tables that levels are looked up in.
pub struct CpuLevels {
    buckets: Buckets,
    quantized_lods: Vec<LodRecord>,
    error_lods: Vec<LodRecord>,
    /// Made when points are first drawn.
    points: OnceLock<PointLevels>,
}

/// Points of the characters, and the buckets with their densities.
struct PointLevels {
    points: Vec<Option<Vec<PointRecord>>>,
    buckets: Buckets,
}

impl CpuLevels {
    /// # Errors
    /// [`crowd_stages::Error::Tables`] when a character has no levels with index tables.
    pub fn new(data: &CrowdData) -> Result<Self> {
        let buckets = Buckets::of(data)?;
        let (quantized_lods, error_lods) = (buckets.quantized_lods(data), buckets.error_lods());
        Ok(Self { buckets, quantized_lods, error_lods, points: OnceLock::new() })
    }

    /// The levels that the technique would draw; how they are submitted does not matter here. Dots and impostors are the GPU's: here everyone keeps a
    /// mesh.
    pub fn select(&self, crowd: &Crowd, config: &FrameConfig, options: DrawOptions) -> cpu::CpuFrame {
        self.select_meshes(crowd, &FrameConfig { impostor_area_px2: 0.0, ..*config }, options)
    }

    /// The same as the GPU draws them with impostors: who is one counts as the coarsest mesh, out of which it crosses over.
    pub fn select_over_impostors(&self, crowd: &Crowd, config: &FrameConfig, options: DrawOptions) -> cpu::CpuFrame {
        let by_size = options.has_dots() && config.weight != Weight::Error as u32;
        if crowd.data.impostors.is_none() || options.no_impostors || !by_size {
            return self.select(crowd, config, options);
        }
        let mut frame = self.select_meshes(crowd, config, options);
        let Crowd { data, instances, .. } = crowd;
        let culled = cpu::cull_instances(data, instances, config);
        for (i, (instance, cull)) in instances.iter().zip(&culled).enumerate() {
            let character = &data.characters[instance.character as usize];
            if cull.visible == 0 || !is_impostor(character, cull.area_px2, config) {
                continue;
            }
            let (vertex_count, triangle_count) = (character.min_vertex_count, character.min_triangle_count);
            frame.choices[i] = LodChoice { vertex_count, triangle_count };
            if let Some(morph) = frame.morphs.get_mut(i) {
                *morph = MorphRecord { coarser_vertex_count: vertex_count, fraction: 1.0 };
            }
        }
        frame
    }

    fn select_meshes(&self, crowd: &Crowd, config: &FrameConfig, options: DrawOptions) -> cpu::CpuFrame {
        let Crowd { data, instances, .. } = crowd;
        let config = &FrameConfig { dot_area_px2: 0.0, ..*config };
        let by_error = config.weight == Weight::Error as u32;
        match options.technique {
            Technique::PseudoInstancing => cpu::select_full_detail(data, instances, config),
            Technique::Instanced => cpu::select_visible(data, instances, config),
            Technique::Discrete => cpu::select_discrete(data, &self.buckets, instances, config),
            Technique::Points => cpu::select_points(data, &self.point_levels(data).buckets, instances, config),
            Technique::StaticFloor | Technique::Bucketed if options.morphs() && !by_error => {
                cpu::run_morphing_selection(data, &self.buckets, &self.quantized_lods, instances, config)
            }
            Technique::Reform | Technique::StaticFloor | Technique::Bucketed => {
                let lods = match options.levels() {
                    _ if by_error => &self.error_lods,
                    Levels::Continuous => &data.lods,
                    Levels::Quantized => &self.quantized_lods,
                };
                cpu::run_selection(data, lods, instances, config, if by_error { Fit::Fill } else { options.fit })
            }
        }
    }

    /// Number of the finest quantised level of at most so many vertices, 0 the coarsest.
    pub fn level_of(&self, character: u32, vertex_count: u32) -> u32 {
        let finer = 1..self.buckets.sets[character as usize].level_count;
        let count_of = |level: u32| self.buckets.records[self.buckets.at(character, level) as usize].vertex_count;
        finer.take_while(|level| count_of(*level) <= vertex_count).count() as u32
    }

    /// The points of an instance whose level has vertices but no triangles, posed.
    pub fn points(
        &self,
        data: &CrowdData,
        instance: &InstanceRecord,
        choice: LodChoice,
        time_s: f32,
    ) -> Vec<PosedPoint> {
        let points = self.point_levels(data).points[instance.character as usize].as_deref().unwrap_or_default();
        cpu::pose_points(data, &points[..points.len().min(choice.vertex_count as usize)], instance, time_s)
    }

    fn point_levels(&self, data: &CrowdData) -> &PointLevels {
        self.points.get_or_init(|| {
            let points = surface_points(data);
            let buckets = Buckets::with_points(data, &points).expect("the same tables were good when this was made");
            PointLevels { points, buckets }
        })
    }
}
