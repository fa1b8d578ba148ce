//! A pack made ready for the stages: records as they lie, textures decoded into layers of one size.

use crate::layers::decode_layers;
use crate::{DrawnInstance, Impostors, InstanceRecord, Technique};
use crowd_pack::{
    AnimationLayout, CharacterRecord, ClipRecord, JointStorage, LevelRecord, LevelSetRecord, LodRecord, MaterialRecord,
    Pack, Texel, VertexRecord, stored_joint,
};
use glam::{Mat4, Vec4};

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a crowd could not be set up.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An image of the pack did not decode.
    #[error("image {index} of the pack: {problem}")]
    Image {
        /// Index in the image table.
        index: usize,
        /// The decoder's word.
        problem: String,
    },
    /// An impostor's picture did not decode.
    #[error("impostors {index} of the pack: {problem}")]
    Impostor {
        /// Index of the character.
        index: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// The adapter's limits do not allow it.
    #[error("{what}: needs {needed}, the adapter allows {allowed}; {remedy}")]
    Limit {
        /// Of what.
        what: &'static str,
        /// Needed.
        needed: u64,
        /// Allowed.
        allowed: u64,
        /// What the user can do.
        remedy: &'static str,
    },
    /// The device's memory does not hold it.
    #[error("{what}: the GPU has no memory for {bytes} bytes; {remedy}")]
    OutOfMemory {
        /// Of what.
        what: &'static str,
        /// Needed.
        bytes: u64,
        /// What the user can do.
        remedy: &'static str,
    },
    /// Nothing more comes from the device.
    #[error("the GPU device was lost: {0}; make a new device and a new renderer")]
    DeviceLost(String),
    /// A character has no index tables, or they do not fit it.
    #[error("character {character}: no levels with index tables; bake the pack again")]
    Tables {
        /// Index of the character.
        character: usize,
    },
    /// The device was made without a feature that a technique cannot do without.
    #[error("{technique}: the device was made without {feature}; {remedy}")]
    Feature {
        /// Which asked for it.
        technique: Technique,
        /// Its name in wgpu.
        feature: &'static str,
        /// What the user can do.
        remedy: &'static str,
    },
    /// What is drawn into is not what the renderer was made for.
    #[error("{what}: found {found}, allowed {allowed}; {remedy}")]
    Target {
        /// Which.
        what: &'static str,
        /// Found.
        found: String,
        /// Allowed.
        allowed: String,
        /// What the user can do.
        remedy: &'static str,
    },
    /// A camera's depth goes the other way than the renderer's.
    #[error(
        "clip_from_world: found depth {found}, allowed {allowed}, as the renderer was made; RendererOptions::reverse_z says which (true: 1 near and 0 far)"
    )]
    DepthRange {
        /// Found.
        found: &'static str,
        /// Allowed.
        allowed: &'static str,
    },
    /// A frame of the static floor was asked for that nobody baked.
    #[error("static-floor: no frame is baked; call bake_floor before")]
    NoFloor,
    /// A simulator's instances cannot be drawn from its buffers.
    #[error("{what}: found {problem}")]
    Feed {
        /// Of what.
        what: &'static str,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A flock cannot be simulated.
    #[error("flock: {problem}")]
    Flock {
        /// What does not fit.
        problem: &'static str,
    },
    /// A reference camera was asked for where no frame is kept.
    #[error(
        "reference camera: {technique} keeps no frame to be seen from elsewhere; draw one before, without occlusion culling"
    )]
    NoFrame {
        /// Which was asked.
        technique: Technique,
    },
    /// No adapter, no device.
    #[error("no usable GPU: {0}")]
    NoAdapter(String),
    /// An instance names a character or clip that is not there.
    #[error("instance {index}: {what} {found}, the pack has {allowed}")]
    Instance {
        /// Of the instance.
        index: usize,
        /// `character`, `clip` or `leaving clip`.
        what: &'static str,
        /// Found.
        found: u32,
        /// Count.
        allowed: u32,
    },
    /// An instance stands nowhere or is of no size.
    #[error("instance {index}: {what} {found}, allowed a finite number")]
    NotFinite {
        /// Of the instance.
        index: usize,
        /// `position`, `yaw`, `scale`, `phase`, `leaving phase` or `held`.
        what: &'static str,
        /// Found.
        found: f32,
    },
    /// What instances play from second to second cannot be followed.
    #[error("{what} {index}: found {found}, allowed {allowed}")]
    Motion {
        /// `motion`, `schedule` or `stretch`.
        what: &'static str,
        /// Of it.
        index: usize,
        /// Found.
        found: String,
        /// What may be there.
        allowed: &'static str,
    },
    /// An instance leaves a clip by a share that is none.
    #[error("instance {index}: share of the clip it leaves {found}, allowed 0 to 1")]
    Share {
        /// Of the instance.
        index: usize,
        /// Found.
        found: f32,
    },
}

/// CPU-side copy of everything the stages read. All characters in one set of arrays (Dong 2019 §5).
#[derive(Debug, Clone, Default)]
pub struct CrowdData {
    /// Characters.
    pub characters: Vec<CharacterRecord>,
    /// Vertices in collapse order.
    pub vertices: Vec<VertexRecord>,
    /// Triangles, indices local to the character.
    pub triangles: Vec<[u32; 3]>,
    /// Collapse targets, local to the character.
    pub collapse_map: Vec<u32>,
    /// LOD tables.
    pub lods: Vec<LodRecord>,
    /// Where each character's levels with index tables lie.
    pub level_sets: Vec<LevelSetRecord>,
    /// All levels with index tables.
    pub levels: Vec<LevelRecord>,
    /// Indices of levels of few vertices, local to the character.
    pub indices_16: Vec<u16>,
    /// Indices of the others.
    pub indices_32: Vec<u32>,
    /// Clips.
    pub clips: Vec<ClipRecord>,
    /// Frames of premultiplied matrices as each character stores its joints (a split pack is multiplied on loading, and the
    /// clips' texel offsets are rewritten).
    pub animation: Vec<Texel>,
    /// Of each clip, the speed of its fastest vertex ([`crate::cpu::clip_speeds`]), for poses that are held; empty until someone wants
    /// them.
    pub clip_speeds: Vec<f32>,
    /// Materials; `image` is a layer index here, or `crowd_pack::NONE`.
    pub materials: Vec<MaterialRecord>,
    /// Texture layers, all `layer_side` x `layer_side`, sRGB-encoded RGBA8 with mip levels: means of the texels that a character shows.
    pub layers: Vec<TextureLayer>,
    /// Side of a layer in pixels, a power of two.
    pub layer_side: u32,
    /// Pictures for those who are a few pixels high, where the pack has them.
    pub impostors: Option<Impostors>,
}

/// One decoded texture, resampled to the common size, with all mip levels down to 1 x 1.
#[derive(Debug, Clone, Default)]
pub struct TextureLayer {
    /// Level 0 first, tightly packed RGBA8.
    pub mips: Vec<Vec<[u8; 4]>>,
}

impl CrowdData {
    /// Unpacks. `max_layer_side` bounds texture memory (1024 is sensible for a crowd).
    ///
    /// Layers get the side of the largest image, rounded up to a power of two, at most `max_layer_side`. A split animation
    /// (Dong 2019 §5.1) is multiplied with its inverse bind matrices here, once.
    ///
    /// # Errors
    /// [`Error::Image`] when an image does not decode, [`Error::Impostor`] when an impostor's picture does not.
    pub fn from_pack(pack: &Pack, max_layer_side: u32) -> Result<Self> {
        let data = Self::without_impostors(pack, max_layer_side)?;
        Ok(Self { impostors: Impostors::of_pack(pack.contents())?, ..data })
    }

    /// The same without impostors, whose pictures then need not be decoded.
    ///
    /// # Errors
    /// [`Error::Image`] when an image does not decode.
    pub fn without_impostors(pack: &Pack, max_layer_side: u32) -> Result<Self> {
        let contents = pack.contents();
        let (layers, layer_side) = decode_layers(contents, max_layer_side)?;
        let mut data = Self {
            characters: contents.characters.clone(),
            vertices: contents.vertices.clone(),
            triangles: contents.triangles.clone(),
            collapse_map: contents.collapse_map.clone(),
            lods: contents.lods.clone(),
            level_sets: contents.level_sets.clone(),
            levels: contents.levels.clone(),
            indices_16: contents.indices_16.clone(),
            indices_32: contents.indices_32.clone(),
            clips: contents.clips.clone(),
            animation: Vec::new(),
            clip_speeds: Vec::new(),
            materials: contents.materials.clone(),
            layers,
            layer_side,
            impostors: None,
        };
        match contents.manifest.animation_layout {
            AnimationLayout::Premultiplied3x4 => data.animation = contents.animation.clone(),
            AnimationLayout::Split4x4 => premultiply(&mut data, &contents.animation, &contents.inverse_binds),
        }
        Ok(data)
    }

    /// Rows of a joint's matrix of an instance: between its two frames, and with those of the clip that it leaves. Twin: `blended_joint` in
    /// `shaders/shared/frames.wgsl`.
    pub(crate) fn blended_joint(&self, drawn: &DrawnInstance, joint: u32) -> [Vec4; 3] {
        let storage = JointStorage::of_code(drawn.storage).unwrap_or_default();
        let at =
            |first: u32| stored_joint(storage, &self.animation[first as usize..], joint as usize).map(Vec4::from_array);
        let between = |first: u32, second: u32, blend: f32| {
            let (a, b) = (at(first), at(second));
            [0, 1, 2].map(|row| a[row] + (b[row] - a[row]) * blend)
        };
        let own = between(drawn.first_texel, drawn.second_texel, drawn.blend);
        if drawn.leaving_share <= 0.0 {
            return own;
        }
        let left = between(drawn.leaving_first_texel, drawn.leaving_second_texel, drawn.leaving_blend);
        [0, 1, 2].map(|row| own[row] + (left[row] - own[row]) * drawn.leaving_share)
    }

    /// Storages that its characters have, a bit each.
    pub(crate) fn joint_storages(&self) -> u32 {
        self.characters.iter().fold(0, |bits, character| bits | 1 << character.joint_storage.min(2))
    }

    /// Checks that instances name characters that are there and clips of those characters, and that their numbers are
    /// finite.
    ///
    /// # Errors
    /// [`Error::Instance`] or [`Error::NotFinite`] for the first that does not.
    pub fn check_instances(&self, instances: &[InstanceRecord]) -> Result<()> {
        check_instances(&self.characters, instances)
    }
}

/// See [`CrowdData::check_instances`].
pub(crate) fn check_instances(characters: &[CharacterRecord], instances: &[InstanceRecord]) -> Result<()> {
    for (index, instance) in instances.iter().enumerate() {
        let Some(character) = characters.get(instance.character as usize) else {
            let allowed = characters.len() as u32;
            return Err(Error::Instance { index, what: "character", found: instance.character, allowed });
        };
        let clips = character.clip_offset..character.clip_offset + character.clip_count;
        if !clips.contains(&instance.clip) {
            return Err(Error::Instance { index, what: "clip", found: instance.clip, allowed: clips.end });
        }
        if !clips.contains(&instance.left_clip()) {
            let found = instance.leaving_clip;
            return Err(Error::Instance { index, what: "leaving clip", found, allowed: clips.end });
        }
        if !(0.0..=1.0).contains(&instance.leaving_share) {
            return Err(Error::Share { index, found: instance.leaving_share });
        }
        let [x, y, z] = instance.position.map(|axis| ("position", axis));
        let [own, left] = [("phase", instance.phase_s), ("leaving phase", instance.leaving_phase_s)];
        let numbers =
            [x, y, z, ("yaw", instance.yaw_rad), ("scale", instance.scale), own, left, ("held", instance.held_s)];
        if let Some((what, found)) = numbers.into_iter().find(|(_, number)| !number.is_finite()) {
            return Err(Error::NotFinite { index, what, found });
        }
    }
    Ok(())
}

/// `world * inverse_bind` for every joint of every frame: four rows become three, clips are written one after the other.
fn premultiply(data: &mut CrowdData, split: &[Texel], inverse_binds: &[[f32; 4]]) {
    let matrix = |rows: &[[f32; 4]]| Mat4::from_cols_array_2d(&[rows[0], rows[1], rows[2], rows[3]]).transpose();
    let stored = |texels: &[Texel]| matrix(&[0, 1, 2, 3].map(|row: usize| texels[row].map(f32::from_bits)));
    for character in &mut data.characters {
        let joint_count = character.joint_count as usize;
        let first_bind = character.inverse_bind_offset as usize;
        let binds: Vec<Mat4> = (0..joint_count).map(|j| matrix(&inverse_binds[first_bind + j * 4..][..4])).collect();
        let clips = character.clip_offset as usize..(character.clip_offset + character.clip_count) as usize;
        for clip in &mut data.clips[clips] {
            let source = clip.texel_offset as usize;
            clip.texel_offset = data.animation.len() as u32;
            for matrix_index in 0..clip.frame_count as usize * joint_count {
                let world = stored(&split[source + matrix_index * 4..][..4]);
                let rows = (world * binds[matrix_index % joint_count]).transpose().to_cols_array_2d();
                data.animation.extend(rows[..3].iter().map(|row| row.map(f32::to_bits)));
            }
        }
        character.inverse_bind_offset = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(m: Mat4) -> [[f32; 4]; 4] {
        m.transpose().to_cols_array_2d()
    }

    #[test]
    fn instances_must_be_somewhere_and_of_some_size() {
        let data = CrowdData {
            characters: vec![CharacterRecord { clip_count: 1, ..Default::default() }],
            ..Default::default()
        };
        let good = InstanceRecord { scale: 1.0, ..Default::default() };
        assert!(data.check_instances(&[good]).is_ok());
        let fades = |leaving_clip, leaving_share| InstanceRecord { leaving_clip, leaving_share, ..good };
        assert!(data.check_instances(&[fades(0, 1.0), fades(9, 0.0)]).is_ok());
        assert!(data.check_instances(&[fades(1, 0.5)]).expect_err("one clip").to_string().contains("leaving clip 1"));
        for share in [-0.1, 1.1] {
            assert!(data.check_instances(&[fades(0, share)]).expect_err("no share").to_string().contains("0 to 1"));
        }
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let table = [
                ("position", InstanceRecord { position: [0.0, odd, 0.0], ..good }),
                ("yaw", InstanceRecord { yaw_rad: odd, ..good }),
                ("scale", InstanceRecord { scale: odd, ..good }),
                ("phase", InstanceRecord { phase_s: odd, ..good }),
                ("leaving phase", InstanceRecord { leaving_phase_s: odd, ..good }),
                ("share", InstanceRecord { leaving_share: odd, ..good }),
            ];
            for (word, instance) in table {
                let error = data.check_instances(&[good, instance]).expect_err("nothing infinite is drawn").to_string();
                assert!(error.starts_with(&format!("instance 1: {word} ")), "{error}");
            }
        }
    }

    #[test]
    fn a_split_animation_becomes_one_matrix_a_joint() {
        let bind = |i: usize| Mat4::from_translation(glam::Vec3::new(i as f32, -1.0, 0.5));
        let world =
            |i: usize| Mat4::from_rotation_y(i as f32 * 0.3) * Mat4::from_translation(glam::Vec3::splat(i as f32));
        // Two clips of two frames of two joints, the second clip first in the section.
        let mut data = CrowdData {
            characters: vec![CharacterRecord { joint_count: 2, clip_count: 2, ..Default::default() }],
            clips: vec![
                ClipRecord { texel_offset: 16, frame_count: 2, ..Default::default() },
                ClipRecord { texel_offset: 0, frame_count: 2, ..Default::default() },
            ],
            ..Default::default()
        };
        let bits = |rows: &[[f32; 4]]| rows.iter().map(|row| row.map(f32::to_bits)).collect::<Vec<Texel>>();
        let split: Vec<Texel> = (0..8).flat_map(|i| bits(&rows(world(i)))).collect();
        let binds: Vec<[f32; 4]> = (0..2).flat_map(|j| rows(bind(j))).collect();
        premultiply(&mut data, &split, &binds);

        assert_eq!((data.clips[0].texel_offset, data.clips[1].texel_offset), (0, 12));
        assert_eq!(data.animation.len(), 8 * 3);
        // First clip, frame 1, joint 1 is matrix 4 + 2 + 1 of the section.
        assert_eq!(data.animation[9..12], bits(&rows(world(7) * bind(1))[..3]));
        // Second clip, frame 0, joint 1.
        assert_eq!(data.animation[15..18], bits(&rows(world(1) * bind(1))[..3]));
    }
}
