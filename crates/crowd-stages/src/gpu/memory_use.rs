//! GPU memory by what it is for, and what frames will ask for that have not been drawn yet.
//!
//! Each formula stands for one constructor and names it; a test holds them equal to what the constructors ask for.

use super::pre_skinning::skinned_room;
use super::renderer::RendererOptions;
use super::targets::DepthWay;
use super::techniques::windows;
use super::{SortAtOnce, SortInstances};
use crate::dispatch::{BLOCK_SIZE, MAX_CASCADES, POINT_LEVELS};
use crate::points::MOST_POINTS;
use crate::{
    BucketCounts, BucketPlace, BucketRange, BucketRecord, Capacities, CascadeStep, DiscreteConfig, DispatchArgs,
    DrawArgs, DrawCounts, DrawnInstance, FillState, FrameConfig, FrameTotals, InstanceBase, LodChoice, MorphRecord,
    PointRecord, PoseCounts, PyramidConfig, ShadowConfig, SightTally, SkinnedVertex, SortPass, Technique, WeightSums,
};
use std::mem::size_of;

/// Bytes of GPU memory by what they are for: buffers and textures, without what the driver needs besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MemoryUse {
    /// Meshes, levels, index tables.
    pub characters: u64,
    /// Stored joints of all clips.
    pub animation: u64,
    /// Texture layers.
    pub images: u64,
    /// Pictures of impostors, and what they are drawn from.
    pub impostors: u64,
    /// Everyone, and what the shared stages know of each.
    pub instances: u64,
    /// What techniques add: sorted lists, draw arguments; index buffer and vertex list of reformation.
    pub techniques: u64,
    /// Palettes and vertices that are worked out before the draw.
    pub skinning: u64,
    /// Who was seen, depth pyramid.
    pub occlusion: u64,
    /// Shadow maps and their casters.
    pub shadows: u64,
    /// The mesh of [`Technique::StaticFloor`].
    pub floor: u64,
    /// Schedules of what people play.
    pub motion: u64,
    /// What a simulator's instances take besides its own buffers.
    pub feed: u64,
    /// Ground and walls.
    pub scenery: u64,
    /// Depth and multisampled colour of the picture's size.
    pub targets: u64,
    /// Times, totals, marks.
    pub others: u64,
}

impl MemoryUse {
    /// All parts by name.
    pub fn parts(&self) -> [(&'static str, u64); 15] {
        [
            ("characters", self.characters),
            ("animation", self.animation),
            ("images", self.images),
            ("impostors", self.impostors),
            ("instances", self.instances),
            ("techniques", self.techniques),
            ("skinning", self.skinning),
            ("occlusion", self.occlusion),
            ("shadows", self.shadows),
            ("floor", self.floor),
            ("motion", self.motion),
            ("feed", self.feed),
            ("scenery", self.scenery),
            ("targets", self.targets),
            ("others", self.others),
        ]
    }

    /// All of it.
    pub fn total(&self) -> u64 {
        self.parts().iter().map(|(_, bytes)| bytes).sum()
    }
}

/// What the formulas need to know of a crowd.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    pub(crate) options: RendererOptions,
    pub(crate) characters: u64,
    pub(crate) buckets: BucketCounts,
    /// 32-bit indices of meshes.
    pub(crate) wide_indices: u64,
    /// Of sharing poses, and how many first poses there are.
    pub(crate) poses: Option<(PoseCounts, u64)>,
    /// Stages run on a processor.
    pub(crate) is_software: bool,
    /// Shadow maps are read from copies.
    pub(crate) copies_maps: bool,
    /// Largest binding, bytes.
    pub(crate) largest_binding: u64,
}

fn bytes<T>(count: u64) -> u64 {
    count.max(1) * size_of::<T>() as u64
}

impl Sizes {
    fn instances(&self) -> u64 {
        self.options.max_instances.into()
    }

    fn blocks(&self) -> u64 {
        self.options.max_instances.div_ceil(BLOCK_SIZE).into()
    }

    /// `BucketDraws::of_tables`.
    fn bucket_draws(&self, bucket_count: u32) -> u64 {
        let (n, buckets) = (self.instances(), u64::from(bucket_count));
        let most = self.options.max_instances;
        let sort = if SortAtOnce::suits(self.is_software, bucket_count) {
            // Sorted keys and instances, and where each stands.
            3 * bytes::<u32>(n) + bytes::<u32>(SortAtOnce::count_words(most, bucket_count))
        } else {
            // Two pairs of sorted keys and instances.
            4 * bytes::<u32>(n) + bytes::<u32>(SortInstances::digit_count_words(most)) + sort_passes(bucket_count)
        };
        // The keys.
        bytes::<u32>(n)
            + sort
            + bytes::<MorphRecord>(n)
            + bytes::<BucketRange>(buckets)
            + bytes::<DrawArgs>(buckets)
            + bytes::<DrawCounts>(1)
            + bytes::<BucketPlace>(buckets + 1)
            + bytes::<DrawnInstance>(n)
    }

    /// `techniques::set_up`.
    pub(crate) fn technique(&self, technique: Technique) -> u64 {
        let draws = |count| self.bucket_draws(count);
        let own = self.buckets.bucket_count;
        match technique {
            Technique::PseudoInstancing | Technique::StaticFloor => 0,
            Technique::Bucketed => draws(own),
            Technique::Instanced => draws(own) + bytes::<WeightSums>(1),
            Technique::Discrete => {
                draws(own) + bytes::<WeightSums>(1) + bytes::<DiscreteConfig>(1) + bytes::<u32>(3 * self.characters)
            }
            Technique::Points => {
                let buckets = self.buckets.mesh_count + self.characters as u32 * POINT_LEVELS;
                draws(buckets)
                    + bytes::<WeightSums>(1)
                    + bytes::<BucketRecord>(buckets.into())
                    + bytes::<BucketCounts>(1)
                    + bytes::<PointRecord>(self.characters * u64::from(MOST_POINTS))
                    + bytes::<u32>(self.wide_indices + u64::from(MOST_POINTS))
            }
            Technique::Reform => {
                let RendererOptions { max_vertices, max_triangles, .. } = self.options;
                let windows = windows(max_triangles, self.largest_binding).len() as u64;
                bytes::<Capacities>(1)
                    + bytes::<Capacities>(windows)
                    + bytes::<InstanceBase>(self.blocks())
                    + bytes::<InstanceBase>(1)
                    + bytes::<InstanceBase>(self.instances())
                    + bytes::<u32>(max_vertices.into())
                    + bytes::<u32>(3 * u64::from(max_triangles))
                    + bytes::<DrawArgs>(1)
            }
        }
    }

    /// `Floor::bake` of as much as a frame may have.
    pub(crate) fn floor(&self) -> u64 {
        32 * u64::from(self.options.max_vertices) + 12 * u64::from(self.options.max_triangles)
    }

    /// `PreSkinning::new`.
    pub(crate) fn skinning(&self) -> u64 {
        let slots = self.instances().min(self.buckets.palette_slots.into());
        bytes::<[f32; 4]>(slots * u64::from(self.buckets.palette_rows))
            + bytes::<SkinnedVertex>(skinned_room(self.options.max_vertices, self.largest_binding).into())
            + bytes::<DispatchArgs>(1)
            + bytes::<Capacities>(1)
    }

    /// `PoseSharing::new`.
    pub(crate) fn pose_sharing(&self) -> u64 {
        let Some((counts, first_poses)) = self.poses else { return 0 };
        let n = self.instances();
        bytes::<PoseCounts>(1)
            + bytes::<u32>(first_poses)
            // Keys, two pairs of sorted ones, leaders.
            + 6 * bytes::<u32>(n)
            + bytes::<u32>(SortInstances::digit_count_words(self.options.max_instances))
            + bytes::<LodChoice>(n)
            + bytes::<InstanceBase>(self.blocks())
            + bytes::<InstanceBase>(n)
            + bytes::<InstanceBase>(1)
            + bytes::<BucketRange>(counts.bucket_count.into())
            + sort_passes(counts.bucket_count << counts.pose_bits | counts.own_pose)
    }

    /// `Occlusion::new` and `Occlusion::fit`.
    pub(crate) fn occlusion(&self, (width, height): (u32, u32)) -> u64 {
        let pyramid = PyramidConfig::new(width, height, self.options.sample_count);
        bytes::<u32>(self.instances() + 1)
            + bytes::<SightTally>(1)
            + bytes::<SightTally>(self.blocks())
            + bytes::<FrameConfig>(1)
            + bytes::<WeightSums>(1)
            + bytes::<FillState>(1)
            + bytes::<FrameTotals>(1)
            + bytes::<u32>(9)
            + bytes::<PyramidConfig>(1)
            + bytes::<f32>(pyramid.number_count().into())
    }

    /// `Shadows::new`.
    pub(crate) fn shadows(&self, side: u32) -> u64 {
        let maps = u64::from(MAX_CASCADES);
        let map = 4 * u64::from(side) * u64::from(side);
        // The copies, and what one goes through.
        map * maps
            + if self.copies_maps { map * (maps + 1) } else { 0 }
            + bytes::<ShadowConfig>(1)
            + bytes::<LodChoice>(self.instances())
            // Where each instance's vertices are.
            + bytes::<u32>(self.instances())
            + bytes::<FrameTotals>(1)
            + bytes::<WeightSums>(1)
            + maps * (bytes::<FrameConfig>(1) + bytes::<CascadeStep>(1))
            + self.bucket_draws(self.buckets.bucket_count)
    }

    /// `DrawCrowd::fit_targets`. `color_bytes`: of a sample.
    pub(crate) fn targets(&self, (width, height): (u32, u32), color_bytes: u32) -> u64 {
        let samples = u64::from(width) * u64::from(height) * u64::from(self.options.sample_count);
        let color_bytes = if self.options.sample_count > 1 { color_bytes } else { 0 };
        samples * (DepthWay::of(&self.options).bytes() + u64::from(color_bytes))
    }
}

fn sort_passes(largest_key: u32) -> u64 {
    bytes::<SortPass>(SortInstances::passes(largest_key).len() as u64)
}
