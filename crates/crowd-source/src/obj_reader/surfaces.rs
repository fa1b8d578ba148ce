//! MTL libraries: diffuse colour and texture; for exports also light of its own (`Ke`, `map_Ke`), a normal map (`norm`), metal and roughness
//! (`Pm`, `Pr`). Paths follow the folder rule.

use std::collections::BTreeMap;

use crate::character::blend_cutoff;
use crate::folder::Folder;
use crate::image_header::read_image;
use crate::names::{name_or, shorten};
use crate::refusal::{Asset, Warnings};
use crate::{Error, RawFilters, RawFinish, RawImage, RawMaterial, RawTexture, RawWrap, Result};

/// Textures that nothing of ours or of glTF's materials stands for.
const LEFT_OUT: [&str; 9] = ["map_Bump", "map_bump", "bump", "disp", "map_Ks", "map_Ns", "map_Pm", "map_Pr", "map_Ps"];

/// Reads a library and keeps the lines that matter and are whole; tobj panics on a `Kd` of two numbers.
pub(super) fn read_library(
    asset: Asset<'_>,
    folder: &Folder<'_>,
    name: &str,
    warnings: &mut Warnings,
) -> Result<String> {
    let place = format!("mtllib `{}`", shorten(name));
    let bytes = match folder.read_path("mtllib", name) {
        Ok(bytes) => bytes,
        Err(Error::NamedFile { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
            let message = "the material library is missing, so everything is white; put it beside the OBJ";
            warnings.add("material-library-missing", &place, 1, message);
            return Ok(String::new());
        }
        Err(error) => return Err(error),
    };
    let text = super::clean::decode_text(asset, &bytes)?;
    let mut kept = String::with_capacity(text.len());
    let mut named = false;
    for line in text.lines() {
        let line = line.trim();
        let Some((word, rest)) = line.split_once(char::is_whitespace) else { continue };
        let rest = rest.trim();
        let numbers = || rest.split_whitespace().map_while(|w| w.parse::<f32>().ok().filter(|n| n.is_finite())).count();
        let whole = match word {
            "newmtl" => !rest.is_empty(),
            "Kd" | "Ke" => numbers() >= 3,
            "d" | "Pm" | "Pr" => numbers() >= 1,
            "map_Kd" | "map_d" | "map_Ke" | "norm" => !rest.is_empty(),
            _ if LEFT_OUT.contains(&word) => {
                // A map_Bump is a height map or a normal map, and nothing in the file says which.
                let message =
                    format!("left out of exports: lines like `{}`; normal maps are read from `norm`", shorten(line));
                warnings.add("material-reduced", &format!("{place}: {word}"), 1, message);
                continue;
            }
            _ => continue,
        };
        named |= word == "newmtl";
        if whole && named {
            kept.push_str(&format!("{word} {rest}\n"));
        } else {
            warnings.add(
                "material-lines-ignored",
                &place,
                1,
                format!("lines that are not whole, like `{}`", shorten(line)),
            );
        }
    }
    Ok(kept)
}

/// The textures that a library names, options left out.
pub(super) fn list_textures(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| {
        let (word, rest) = line.trim().split_once(char::is_whitespace)?;
        let names_one = word.starts_with("map_") || matches!(word, "bump" | "disp" | "norm");
        names_one.then(|| split_texture_options(rest).2)
    })
}

/// The materials that parts use, in the order of their first use, and their images.
pub(super) struct SurfaceTable<'a> {
    asset: Asset<'a>,
    folder: &'a Folder<'a>,
    found: &'a [tobj::Material],
    known: BTreeMap<(Option<usize>, bool), u32>,
    known_images: BTreeMap<String, u32>,
    known_finish_images: BTreeMap<String, u32>,
    pub(super) materials: Vec<RawMaterial>,
    pub(super) images: Vec<RawImage>,
    /// Those that are carried to exports and not shown.
    pub(super) finish_images: Vec<RawImage>,
}

impl<'a> SurfaceTable<'a> {
    pub(super) fn new(asset: Asset<'a>, folder: &'a Folder<'a>, found: &'a [tobj::Material]) -> Self {
        Self {
            asset,
            folder,
            found,
            known: BTreeMap::new(),
            known_images: BTreeMap::new(),
            known_finish_images: BTreeMap::new(),
            materials: Vec::new(),
            images: Vec::new(),
            finish_images: Vec::new(),
        }
    }

    /// The character's index of a material; `flat` where its part has no normals.
    pub(super) fn index(&mut self, material: Option<usize>, flat: bool, warnings: &mut Warnings) -> Result<u32> {
        if let Some(index) = self.known.get(&(material, flat)) {
            return Ok(*index);
        }
        let mut made = match material.and_then(|m| self.found.get(m)) {
            None => crate::gltf_reader::default_material(),
            Some(found) => self.read_material(found, warnings)?,
        };
        made.flat_normals = flat;
        let index = self.materials.len() as u32;
        self.materials.push(made);
        self.known.insert((material, flat), index);
        Ok(index)
    }

    /// `Kd` is taken as a linear factor as it stands: MTL never said which it is, and most readers do so.
    fn read_material(&mut self, found: &tobj::Material, warnings: &mut Warnings) -> Result<RawMaterial> {
        let place = format!("material `{}`", shorten(&found.name));
        let mut diffuse = found.diffuse.unwrap_or([1.0; 3]);
        let texture = match &found.diffuse_texture {
            None => None,
            Some(text) => {
                let (known, images) = (&mut self.known_images, &mut self.images);
                Some(read_texture(self.asset, self.folder, (known, images), (&place, "map_Kd", text), warnings)?)
            }
        };
        if texture.is_some() && diffuse == [0.0; 3] {
            let message = "a black Kd would hide the texture and was taken as white";
            warnings.add("black-factor-ignored", &place, 1, message);
            diffuse = [1.0; 3];
        }
        let alpha = found.dissolve.unwrap_or(1.0);
        let mut alpha_cutoff = None;
        if alpha < 1.0 || found.dissolve_texture.is_some() {
            let cutoff = blend_cutoff(alpha);
            let message = format!(
                "transparency (d, map_d) is drawn as a mask with cutoff {cutoff} on the texture's alpha: pixels are there or not"
            );
            warnings.add("alpha-blend-as-mask", &place, 1, message);
            alpha_cutoff = Some(cutoff);
        }
        let [r, g, b] = diffuse;
        let finish = self.read_finish(&place, found, warnings);
        Ok(RawMaterial {
            name: name_or(Some(&found.name), || "material".to_owned()),
            base_color: [r, g, b, alpha],
            texture,
            alpha_cutoff,
            double_sided: false,
            unlit: false,
            flat_normals: false,
            finish,
        })
    }

    /// Nothing here refuses a character: what cannot be carried is left out and named.
    fn read_finish(&mut self, place: &str, found: &tobj::Material, warnings: &mut Warnings) -> RawFinish {
        let mut texture = |word: &str| {
            let text = found.unknown_param.get(word)?;
            let (known, images) = (&mut self.known_finish_images, &mut self.finish_images);
            match read_texture(self.asset, self.folder, (known, images), (place, word, text), warnings) {
                Ok(texture) => Some(texture),
                Err(error) => {
                    let message = format!("left out of exports: {error}");
                    warnings.add("material-reduced", &format!("{place}: {word}"), 1, message);
                    None
                }
            }
        };
        let (emissive_texture, normal) = (texture("map_Ke"), texture("norm"));
        let number = |word: &str| {
            let number = found.unknown_param.get(word)?.split_whitespace().next()?.parse::<f32>().ok()?;
            number.is_finite().then(|| number.clamp(0.0, 1.0))
        };
        let unit = |channel: f32| if channel.is_finite() { channel.clamp(0.0, 1.0) } else { 0.0 };
        let factor = found.emissive.map(|factor| factor.map(unit));
        // As with Kd, a black factor beside a texture is an exporter's way to say nothing.
        let factor = factor.filter(|factor| emissive_texture.is_none() || *factor != [0.0; 3]);
        let plain = RawFinish::default();
        RawFinish {
            metallic: number("Pm").unwrap_or(plain.metallic),
            roughness: number("Pr").unwrap_or(plain.roughness),
            normal: normal.map(|texture| (texture, 1.0)),
            emissive: factor.unwrap_or([if emissive_texture.is_some() { 1.0 } else { 0.0 }; 3]),
            emissive_texture,
            ..plain
        }
    }
}

/// A texture, its image put into that table: by name where it is, and the images.
fn read_texture(
    asset: Asset<'_>,
    folder: &Folder<'_>,
    (known, images): (&mut BTreeMap<String, u32>, &mut Vec<RawImage>),
    (place, word, text): (&str, &str, &str),
    warnings: &mut Warnings,
) -> Result<RawTexture> {
    let (clamp, ignored, name) = split_texture_options(text);
    let message = "texture options other than -clamp are ignored";
    warnings.add("texture-options-ignored", place, ignored, message);
    let wrap = if clamp { RawWrap::Clamp } else { RawWrap::Repeat };
    let here = format!("{place}: {word} `{}`", shorten(name));
    let image = match known.get(name) {
        Some(index) => *index,
        None => {
            let bytes = folder.read_path(&format!("{place}: {word}"), name)?;
            let file_name = name.rsplit(['/', '\\']).next().unwrap_or(name);
            images.push(read_image(asset, &here, shorten(file_name), bytes)?);
            let index = images.len() as u32 - 1;
            known.insert(name.to_owned(), index);
            index
        }
    };
    Ok(RawTexture { image, wrap_u: wrap, wrap_v: wrap, filters: RawFilters::default() })
}

/// Options before a texture's file name, which may hold blanks: (`-clamp on`, how many others, the name).
fn split_texture_options(text: &str) -> (bool, u64, &str) {
    let (mut clamp, mut ignored, mut rest) = (false, 0, text.trim());
    while rest.starts_with('-') {
        let (option, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let numbers = match option {
            "-o" | "-s" | "-t" => 3,
            "-mm" => 2,
            "-blendu" | "-blendv" | "-boost" | "-texres" | "-clamp" | "-bm" | "-imfchan" | "-type" | "-cc" => 1,
            _ => break,
        };
        let mut after = after.trim_start();
        for given in 0..numbers {
            let (word, next) = after.split_once(char::is_whitespace).unwrap_or((after, ""));
            // `-s` and its kin take one to three numbers.
            if given > 0 && word.parse::<f32>().is_err() {
                break;
            }
            clamp |= option == "-clamp" && word == "on";
            after = next.trim_start();
        }
        ignored += u64::from(option != "-clamp");
        rest = after;
    }
    (clamp, ignored, rest)
}
