//! Animations as clips: checked curves of the nodes that matter.

use std::collections::BTreeSet;

use glam::{DQuat, Quat};
use gltf::json::Root;
use gltf::json::accessor::ComponentType::{F32, I8, I16, U8, U16};
use gltf::json::animation::{Animation, Channel, Interpolation, Property};
use gltf::json::validation::Checked;

use super::accessors::open_accessor;
use super::buffers::Buffers;
use super::document::describe;
use crate::names::name_or;
use crate::refusal::{Asset, Warnings};
use crate::{RawClip, RawInterpolation, RawProperty, RawTrack, Result};

/// Reads all animations. `node_remap` gives kept nodes by document index; `moving[n]` says whether kept node n carries
/// a joint, itself or further down: other nodes move nothing, and their curves are kept apart.
pub(super) fn read_clips(
    asset: Asset<'_>,
    root: &Root,
    buffers: &Buffers<'_>,
    node_remap: &[Option<u32>],
    moving: &[bool],
    warnings: &mut Warnings,
) -> Result<Vec<RawClip>> {
    let mut clips = Vec::new();
    let mut names = BTreeSet::new();
    let (mut keys_read, mut spare_keys_read) = (0, 0);
    for (index, animation) in root.animations.iter().enumerate() {
        let place = describe("animation", index, animation.name.as_ref());
        let reader = ClipReader { asset, root, buffers, node_remap, moving, place };
        let tracks = reader.read_tracks(animation, &mut keys_read, warnings)?;
        if tracks.is_empty() {
            let message = "the animation moves no joint of the character and was left out";
            warnings.add("clip-without-tracks", &reader.place, 1, message);
            continue;
        }
        let name = name_or(animation.name.as_deref(), || format!("clip {index}"));
        let spare_tracks = reader.read_spare_tracks(animation, &mut spare_keys_read);
        let name = unique_name(name, &mut names);
        if animation.name.as_deref() != Some(name.as_str()) {
            let why = match animation.name.as_deref() {
                None | Some("") => "it has no name",
                Some(own) if name.starts_with(own) => "another clip has its name",
                Some(_) => "its name is too long or would steer a terminal",
            };
            let message =
                format!("the clip is called `{name}` from here on, in exports too: {why}; name it in the file");
            warnings.add("clip-renamed", &reader.place, 1, &message);
        }
        clips.push(RawClip { name, tracks, spare_tracks });
    }
    Ok(clips)
}

fn unique_name(name: String, names: &mut BTreeSet<String>) -> String {
    if names.insert(name.clone()) {
        return name;
    }
    let unique = (2u64..).map(|n| format!("{name} ({n})")).find(|candidate| names.insert(candidate.clone()));
    unique.expect("the numbers do not end before the clips do")
}

struct ClipReader<'a, 'b> {
    asset: Asset<'a>,
    root: &'a Root,
    buffers: &'a Buffers<'b>,
    node_remap: &'a [Option<u32>],
    moving: &'a [bool],
    place: String,
}

impl ClipReader<'_, '_> {
    fn read_tracks(
        &self,
        animation: &Animation,
        keys_read: &mut u64,
        warnings: &mut Warnings,
    ) -> Result<Vec<RawTrack>> {
        let mut tracks: Vec<RawTrack> = Vec::new();
        let mut taken = BTreeSet::new();
        for (number, channel) in animation.channels.iter().enumerate() {
            let here = format!("{} channel {number}", self.place);
            let property = match channel.target.path {
                Checked::Valid(Property::Translation) => RawProperty::Translation,
                Checked::Valid(Property::Rotation) => RawProperty::Rotation,
                Checked::Valid(Property::Scale) => RawProperty::Scale,
                Checked::Valid(Property::MorphTargetWeights) => {
                    let message =
                        "curves of morph target weights were left out; bake the shapes into the mesh before export";
                    warnings.add("morph-curves-ignored", &self.place, 1, message);
                    continue;
                }
                Checked::Invalid => {
                    let message = "curves of something else than translation, rotation and scale were left out";
                    warnings.add("unknown-curves-ignored", &self.place, 1, message);
                    continue;
                }
            };
            let Some(node) = self.node_remap.get(channel.target.node.value()) else {
                let problem = format!("node {}, the file has {}", channel.target.node.value(), self.node_remap.len());
                return Err(self.asset.format(here, problem));
            };
            let Some(node) = node.filter(|n| self.moving[*n as usize]) else { continue };
            if !taken.insert((node, property)) {
                let message = "a second curve for the same node and property was left out";
                warnings.add("double-curves-ignored", &self.place, 1, message);
                continue;
            }
            tracks.push(self.read_track(here, animation, channel, node, property, keys_read, warnings)?);
        }
        Ok(tracks)
    }

    /// Curves of nodes that move nothing. The first that is not in order, or one too many, ends it for the whole file: nothing of the
    /// character depends on them.
    fn read_spare_tracks(&self, animation: &Animation, keys_read: &mut u64) -> Vec<RawTrack> {
        let mut tracks = Vec::new();
        let mut taken = BTreeSet::new();
        for channel in &animation.channels {
            let property = match channel.target.path {
                Checked::Valid(Property::Translation) => RawProperty::Translation,
                Checked::Valid(Property::Rotation) => RawProperty::Rotation,
                Checked::Valid(Property::Scale) => RawProperty::Scale,
                _ => continue,
            };
            let node = self.node_remap.get(channel.target.node.value()).copied().flatten();
            let Some(node) = node.filter(|node| !self.moving[*node as usize]) else { continue };
            if *keys_read > self.asset.limits.keys || !taken.insert((node, property)) {
                continue;
            }
            let mut unsaid = Warnings::default();
            match self.read_track(String::new(), animation, channel, node, property, keys_read, &mut unsaid) {
                Ok(track) => tracks.push(track),
                Err(_) => *keys_read = u64::MAX,
            }
        }
        tracks
    }

    fn read_track(
        &self,
        here: String,
        animation: &Animation,
        channel: &Channel,
        node: u32,
        property: RawProperty,
        keys_read: &mut u64,
        warnings: &mut Warnings,
    ) -> Result<RawTrack> {
        let Some(sampler) = animation.samplers.get(channel.sampler.value()) else {
            let problem =
                format!("sampler {}, the animation has {}", channel.sampler.value(), animation.samplers.len());
            return Err(self.asset.format(here, problem));
        };
        let interpolation = match sampler.interpolation {
            Checked::Valid(Interpolation::Linear) => RawInterpolation::Linear,
            Checked::Valid(Interpolation::Step) => RawInterpolation::Step,
            Checked::Valid(Interpolation::CubicSpline) => RawInterpolation::CubicSpline,
            Checked::Invalid => {
                return Err(self.asset.format(here, "`interpolation` is none of LINEAR, STEP, CUBICSPLINE"));
            }
        };
        let times = self.read_times(&format!("{here}: input"), sampler.input.value())?;
        *keys_read += times.len() as u64;
        self.asset.check_limit(&here, "key frames", *keys_read, self.asset.limits.keys)?;

        let output = format!("{here}: output");
        let allowed = ("values", self.asset.limits.keys.saturating_mul(3));
        let elements = open_accessor(self.asset, self.root, self.buffers, &output, sampler.output.value(), allowed)?;
        let rotation = property == RawProperty::Rotation;
        if rotation {
            elements.expect(&[4], &[F32, I8, U8, I16, U16])?;
        } else {
            elements.expect(&[3], &[F32, I8, U8, I16, U16])?;
        }
        let per_key = if interpolation == RawInterpolation::CubicSpline { 3 } else { 1 };
        if elements.count != times.len() * per_key {
            let problem = format!("{} values for {} keys, expected {per_key} a key", elements.count, times.len());
            return Err(self.asset.format(output, problem));
        }
        let mut values = elements.read_floats(elements.normalized || rotation)?;
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let problem = format!("value {} is {}; values are finite", at / elements.width, values[at]);
            return Err(self.asset.format(output, problem));
        }
        if rotation {
            let repaired = normalize_keys(&mut values, per_key);
            let message = "key rotations of length zero were taken as none";
            warnings.add("rotation-keys-repaired", &self.place, repaired, message);
        }
        Ok(RawTrack { node, property, interpolation, times, values })
    }

    fn read_times(&self, place: &str, accessor: usize) -> Result<Vec<f32>> {
        let allowed = ("key frames", self.asset.limits.keys);
        let elements = open_accessor(self.asset, self.root, self.buffers, place, accessor, allowed)?;
        elements.expect(&[1], &[F32])?;
        let times = elements.read_floats(false)?;
        if times.is_empty() {
            return Err(self.asset.format(place, "no keys"));
        }
        if let Some(key) = times.iter().position(|t| !t.is_finite()) {
            return Err(self.asset.format(place, format!("key {key} is at {} s; times are finite", times[key])));
        }
        if let Some(key) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let problem = format!(
                "key {} is at {} s, key {key} before it at {} s; times increase strictly",
                key + 1,
                times[key + 1],
                times[key]
            );
            return Err(self.asset.format(place, problem));
        }
        Ok(times)
    }
}

/// Makes key quaternions unit ones; tangents of splines stay as they are. Returns how many had no length.
fn normalize_keys(values: &mut [f32], per_key: usize) -> u64 {
    let mut repaired = 0;
    let value_in_key = if per_key == 3 { 1 } else { 0 };
    for quaternion in values.chunks_exact_mut(4).skip(value_in_key).step_by(per_key) {
        let exact: DQuat = Quat::from_slice(quaternion).as_dquat();
        let unit = if exact.length_squared() > 1e-24 {
            exact.normalize()
        } else {
            repaired += 1;
            DQuat::IDENTITY
        };
        quaternion.copy_from_slice(&unit.as_quat().to_array());
    }
    repaired
}
