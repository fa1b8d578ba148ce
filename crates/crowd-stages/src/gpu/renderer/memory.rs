//! What a renderer has asked for, and what it will.

use super::super::memory_use::{MemoryUse, Sizes};
use super::{CrowdRenderer, RendererOptions};
use crate::dispatch::{DOT_VERTICES, IMPOSTOR_TRIANGLES};
use crate::dots::{DOT_COUNTS, dots_are_coarser};
use crate::impostors::{fade_level, stands_in};
use crate::{DrawOptions, MarkConfig, Skinning, Technique, View, shadow_side};
use crowd_pack::CharacterRecord;
use std::mem::size_of;

impl CrowdRenderer {
    /// Bytes of GPU memory this renderer asked for.
    pub fn gpu_bytes(&self) -> u64 {
        self.memory().total()
    }

    /// The same by what they are for.
    pub fn memory(&self) -> MemoryUse {
        let others = self.memory.others + self.meters.bytes() + self.unshaded.bytes();
        MemoryUse { targets: self.draw.target_bytes(), others, ..self.memory }
    }

    /// What it will have asked for once [`Self::encode`] has drawn frames of all of `draws` ([`Self::encode_into`] needs no `targets`),
    /// `size` pixels large, with room for as much as `options` says: what is there already (the crowd, its instances), and what is set up when it is first asked for. [`Skinning::Auto`]
    /// counts with all it tries; of a floor, the most it can come to. Of what a reference camera needs [`Self::prepare_marks`] says.
    pub fn memory_of(&self, options: RendererOptions, draws: &[DrawOptions], size: (u32, u32)) -> MemoryUse {
        let sizes = self.sizes(options);
        let size = (size.0.max(1), size.1.max(1));
        let any = |what: fn(&DrawOptions) -> bool| draws.iter().any(what);
        let when = |is_asked: bool, bytes: u64| if is_asked { bytes } else { 0 };
        let techniques = Technique::ALL.into_iter().filter(|t| draws.iter().any(|draw| draw.technique == *t));
        let skins = any(|draw| draw.technique == Technique::Bucketed && draw.skinning != Skinning::Vertex);
        let skinning = when(skins, sizes.skinning());
        let marks = self.marks.is_none() && any(|draw| draw.shown_view() != View::Shaded);
        let present = self.memory();
        let color_bytes = options.color_format.block_copy_size(None).unwrap_or(4);
        MemoryUse {
            techniques: techniques.map(|technique| sizes.technique(technique)).sum(),
            skinning: skinning + when(skinning > 0 && any(DrawOptions::shares_poses), sizes.pose_sharing()),
            occlusion: when(any(DrawOptions::occludes), sizes.occlusion(size)),
            shadows: when(any(|draw| draw.shadows > 0), sizes.shadows(shadow_side(size.1))),
            floor: when(any(|draw| draw.technique == Technique::StaticFloor), sizes.floor()),
            targets: sizes.targets(size, color_bytes),
            others: present.others + when(marks, size_of::<MarkConfig>() as u64),
            ..present
        }
    }

    /// From now on with room for so many vertices and triangles a frame. What was set up for others goes; it comes anew when it is
    /// asked for.
    pub fn make_room(&mut self, max_vertices: u32, max_triangles: u32) {
        self.options = RendererOptions { max_vertices, max_triangles, ..self.options };
        self.painters = Default::default();
        if let Some(shadows) = &mut self.shadows {
            shadows.forget_lender();
        }
        self.holds_frame = Default::default();
        (self.memory.techniques, self.memory.skinning, self.memory.floor) = (0, 0, 0);
    }

    fn sizes(&self, options: RendererOptions) -> Sizes {
        let tables = &self.crowd.tables;
        let dots = |character| DOT_COUNTS.into_iter().filter(move |dots| dots_are_coarser(character, *dots)).sum();
        let dot_indices: u32 = self.characters.iter().map(|c| -> u32 { dots(c) }).sum::<u32>() * DOT_VERTICES;
        let stand_in = |c: &CharacterRecord| {
            if stands_in(c.min_vertex_count, 0.0, 1.0) { fade_level(c).triangle_count } else { 0 }
        };
        let impostor_triangles = self.characters.iter().map(stand_in).sum::<u32>() + IMPOSTOR_TRIANGLES;
        let impostor_indices = if self.crowd.impostors.is_some() { 3 * impostor_triangles } else { 0 };
        let indices = tables.indices_32_bytes() / size_of::<u32>() as u64;
        Sizes {
            options: RendererOptions { max_instances: self.options.max_instances, ..options },
            characters: self.characters.len() as u64,
            buckets: tables.counts,
            wide_indices: indices.saturating_sub((dot_indices + impostor_indices).into()),
            poses: self.crowd.poses.as_ref().map(|(counts, first)| (*counts, first.len() as u64)),
            is_software: self.is_software,
            copies_maps: self.unshaded.is_copied(),
            largest_binding: self.largest_binding,
        }
    }
}
