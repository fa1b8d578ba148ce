//! What materials have beside their base colour, and names: for exports, not for drawing. Bincode with a byte limit, as the manifest.

use crate::check_contents::{check_image_records, expect, expect_finite};
use crate::check_manifest::{check_track, decode_value, encode_value};
use crate::layout::refuse_above;
use crate::{ManifestJoint, ManifestTrack, NONE, PackContents, Result, limits};
use serde::{Deserialize, Serialize};

/// The `finishes` section. A pack of plain materials and no names has none: all lists are empty then.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Finishes {
    /// One per material record.
    pub materials: Vec<Finish>,
    /// Names of the images, one each; empty for those that have none.
    pub image_names: Vec<String>,
    /// The same of `finish_images`.
    pub finish_image_names: Vec<String>,
    /// Names of the characters' skins, one each; empty for those that have none.
    pub skin_names: Vec<String>,
    /// The characters' rigs, one each.
    pub rigs: Vec<Rig>,
    /// What the characters' files say of their makers, one each.
    pub credits: Vec<Credits>,
}

/// What a character's file says of its makers and its licence.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Credits {
    /// glTF's `asset.copyright`; empty where there is none.
    pub copyright: String,
    /// glTF's `asset.extras`, the text of a JSON object; empty where there is none.
    pub extras: String,
}

/// The skin of a character as its source has it. Nothing in the lists where that is what the character has.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Rig {
    /// All joints of the skin, used or not.
    pub joints: Vec<ManifestJoint>,
    /// For each of the character's joints, where it stands in that list.
    pub places: Vec<u32>,
    /// Clip by clip, the curves of nodes that move nothing of the mesh.
    pub tracks: Vec<Vec<ManifestTrack>>,
}

/// What a material has beside its record, with glTF 2.0's meaning. The default is a material of nothing else: no metal, rough, dark.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finish {
    /// Metalness, 0 to 1.
    pub metallic: f32,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Roughness in green, metalness in blue.
    pub metallic_roughness: Option<FinishTexture>,
    /// Tangent-space normals; weighed by the factor on their x and y.
    pub normal: Option<FinishTexture>,
    /// Ambient occlusion in red; weighed by its strength, 0 to 1.
    pub occlusion: Option<FinishTexture>,
    /// Light of its own, linear RGB, 0 to 1.
    pub emissive: [f32; 3],
    /// `KHR_materials_emissive_strength`, at least 0.
    pub emissive_strength: f32,
    /// Colour of that light.
    pub emissive_texture: Option<FinishTexture>,
    /// `KHR_materials_ior`.
    pub ior: Option<f32>,
    /// `KHR_materials_specular`: factor and colour.
    pub specular: Option<[f32; 4]>,
    /// The same: factor in alpha.
    pub specular_texture: Option<FinishTexture>,
    /// The same: colour.
    pub specular_color_texture: Option<FinishTexture>,
    /// Alpha mode BLEND, which the record has as a mask.
    pub blend: bool,
    /// The base colour without light of its own, where the record has that added.
    pub base: Option<FinishBase>,
}

/// A texture: an image of `finish_images`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct FinishTexture {
    /// The image.
    pub image: u32,
    /// Wrapping and filters, as bits 4 to 11 of a material's flags: along u, along v times 4, filters times 16.
    pub sampler: u8,
    /// What weighs it: a factor or strength; 1 where there is no such thing.
    pub weight: f32,
}

/// A base colour.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FinishBase {
    /// Linear RGBA.
    pub color: [f32; 4],
    /// Texture.
    pub texture: Option<FinishTexture>,
}

impl Default for Finish {
    fn default() -> Self {
        Self {
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness: None,
            normal: None,
            occlusion: None,
            emissive: [0.0; 3],
            emissive_strength: 1.0,
            emissive_texture: None,
            ior: None,
            specular: None,
            specular_texture: None,
            specular_color_texture: None,
            blend: false,
            base: None,
        }
    }
}

impl Finish {
    /// Its textures.
    pub fn textures(&self) -> impl Iterator<Item = &FinishTexture> {
        let base = self.base.as_ref().and_then(|base| base.texture.as_ref());
        let own = [&self.metallic_roughness, &self.normal, &self.occlusion, &self.emissive_texture];
        let specular = [&self.specular_texture, &self.specular_color_texture];
        own.into_iter().chain(specular).filter_map(Option::as_ref).chain(base)
    }
}

impl Finishes {
    /// Leaves nothing where nothing is said, so that packs of plain materials stay as they are.
    pub fn drop_if_plain(&mut self) {
        let names = [&self.image_names, &self.finish_image_names, &self.skin_names];
        let unnamed = names.into_iter().flatten().all(String::is_empty);
        let no_rigs = self.rigs.iter().all(|rig| *rig == Rig::default());
        let no_credits = self.credits.iter().all(|credits| *credits == Credits::default());
        if unnamed && no_rigs && no_credits && self.materials.iter().all(|finish| *finish == Finish::default()) {
            *self = Self::default();
        }
    }
}

/// The section's bytes; none where there is nothing to say.
pub(crate) fn encode_finishes(finishes: &Finishes) -> Result<Vec<u8>> {
    if *finishes == Finishes::default() { Ok(Vec::new()) } else { encode_value("finishes", finishes) }
}

/// The finishes of these bytes.
pub(crate) fn decode_finishes(bytes: &[u8]) -> Result<Finishes> {
    if bytes.is_empty() {
        return Ok(Finishes::default());
    }
    let finishes = decode_value("finishes", bytes)?;
    let fits = finishes != Finishes::default();
    expect(fits, || "finishes: encoding", "lists of nothing", || "an empty section".to_owned())?;
    Ok(finishes)
}

/// The finishes against the records: nothing at all, or one entry each; images that exist, numbers that are numbers.
pub(crate) fn check_finishes(contents: &PackContents) -> Result<()> {
    check_image_records("finish image", "finish_bytes", &contents.finish_images, &contents.finish_bytes)?;
    let finishes = &contents.finishes;
    if *finishes == Finishes::default() {
        let found = contents.finish_images.len();
        return expect(found == 0, || "section finish_images: elements", found, || "0 without finishes".to_owned());
    }
    for (field, found, count) in [
        ("materials", finishes.materials.len(), contents.materials.len()),
        ("image names", finishes.image_names.len(), contents.images.len()),
        ("names of finish images", finishes.finish_image_names.len(), contents.finish_images.len()),
        ("skin names", finishes.skin_names.len(), contents.characters.len()),
        ("rigs", finishes.rigs.len(), contents.characters.len()),
        ("credits", finishes.credits.len(), contents.characters.len()),
    ] {
        expect(found == count, || format!("finishes: {field}"), found, || format!("{count}, one each"))?;
    }
    for (number, finish) in finishes.materials.iter().enumerate() {
        check_finish(contents, finish, &|field| format!("finishes: material {number}: {field}"))?;
    }
    for (number, rig) in finishes.rigs.iter().enumerate() {
        check_rig(contents, number, rig, &|field| format!("finishes: rig {number}: {field}"))?;
    }
    Ok(())
}

/// Joints on nodes that exist, a place of its own for each of the character's, curves as those of its clips.
fn check_rig(contents: &PackContents, index: usize, rig: &Rig, here: &dyn Fn(&str) -> String) -> Result<()> {
    let record = &contents.characters[index];
    let nodes = contents.manifest.characters[index].nodes.len();
    refuse_above(&here("joints"), rig.joints.len() as u64, limits::JOINTS_PER_CHARACTER)?;
    for (number, joint) in rig.joints.iter().enumerate() {
        let fits = (joint.node as usize) < nodes;
        expect(fits, || here(&format!("joint {number}: node")), joint.node, || format!("below {nodes}"))?;
        expect_finite(&joint.inverse_bind, || here(&format!("joint {number}: inverse bind matrix")))?;
    }
    let (found, joints) = (rig.places.len(), record.joint_count);
    let fits = found == joints as usize || (found == 0 && rig.joints.is_empty());
    expect(fits, || here("places"), found, || format!("{joints}, one a joint, or no joints at all"))?;
    let mut taken = vec![false; rig.joints.len()];
    for &place in &rig.places {
        let fits = taken.get_mut(place as usize).is_some_and(|taken| !std::mem::replace(taken, true));
        expect(fits, || here("place"), place, || format!("below {}, none twice", rig.joints.len()))?;
    }
    let (found, clips) = (rig.tracks.len(), record.clip_count);
    let fits = found == 0 || found == clips as usize;
    expect(fits, || here("tracks"), found, || format!("0, or {clips}, a list a clip"))?;
    for (number, track) in rig.tracks.iter().flatten().enumerate() {
        let place = |field: &str| here(&format!("track {number}: {field}"));
        check_track(&contents.track_values, nodes, track, &place)?;
    }
    Ok(())
}

fn check_finish(contents: &PackContents, finish: &Finish, here: &dyn Fn(&str) -> String) -> Result<()> {
    let units = [finish.metallic, finish.roughness].into_iter().chain(finish.emissive);
    for found in units.chain(finish.occlusion.map(|occlusion| occlusion.weight)) {
        let fits = (0.0..=1.0).contains(&found);
        expect(fits, || here("metalness, roughness, occlusion, emission"), found, || "0 to 1".to_owned())?;
    }
    let strength = finish.emissive_strength;
    let fits = strength.is_finite() && strength >= 0.0;
    expect(fits, || here("emissive strength"), strength, || "finite, at least 0".to_owned())?;
    if let Some(ior) = finish.ior {
        let fits = ior.is_finite() && (ior == 0.0 || ior >= 1.0);
        expect(fits, || here("index of refraction"), ior, || "0, or finite and at least 1".to_owned())?;
    }
    if let Some(specular) = finish.specular {
        let fits = specular.iter().all(|number| number.is_finite() && *number >= 0.0) && specular[0] <= 1.0;
        let allowed = || "finite, at least 0, the first at most 1".to_owned();
        expect(fits, || here("specular"), format_args!("{specular:?}"), allowed)?;
    }
    if let Some(base) = &finish.base {
        expect_finite(&base.color, || here("base colour"))?;
    }
    let images = contents.finish_images.len();
    for texture in finish.textures() {
        let image = texture.image;
        let fits = (image as usize) < images && image != NONE;
        expect(fits, || here("texture: image"), image, || format!("below {images}"))?;
        let sampler = texture.sampler;
        let allowed = || "two wraps of two bits, at most 2, and filters times 16, at most 11".to_owned();
        expect(crate::material_flags::is_sampler(sampler.into()), || here("texture: sampler"), sampler, allowed)?;
        expect_finite(&[texture.weight], || here("texture: weight"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_materials_without_names_take_no_bytes() {
        let mut finishes = Finishes {
            materials: vec![Finish::default(); 2],
            image_names: vec![String::new()],
            finish_image_names: Vec::new(),
            skin_names: vec![String::new()],
            rigs: vec![Rig::default()],
            credits: vec![Credits::default()],
        };
        let mut named = finishes.clone();
        named.skin_names[0] = "rig".into();
        named.drop_if_plain();
        assert_eq!(named.materials.len(), 2);
        let mut credited = finishes.clone();
        credited.credits[0].copyright = "CC-BY 4.0 Ada".into();
        credited.drop_if_plain();
        assert_eq!(credited.credits.len(), 1);
        assert_eq!(decode_finishes(&encode_finishes(&named).unwrap()).unwrap(), named);
        finishes.drop_if_plain();
        assert_eq!(finishes, Finishes::default());
        assert!(encode_finishes(&finishes).unwrap().is_empty());
        assert_eq!(decode_finishes(&[]).unwrap(), finishes);
        // A second way to write nothing.
        assert!(decode_finishes(&[0, 0, 0, 0, 0, 0]).is_err());
    }
}
