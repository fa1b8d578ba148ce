//! MTL libraries: diffuse colour and texture. Paths follow the folder rule.

use std::collections::BTreeMap;

use crate::character::blend_cutoff;
use crate::folder::Folder;
use crate::image_header::read_image;
use crate::names::{name_or, shorten};
use crate::refusal::{Asset, Warnings};
use crate::{Error, RawImage, RawMaterial, RawTexture, RawWrap, Result};

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
            "Kd" => numbers() >= 3,
            "d" => numbers() >= 1,
            "map_Kd" | "map_d" => !rest.is_empty(),
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
    pub(super) materials: Vec<RawMaterial>,
    pub(super) images: Vec<RawImage>,
}

impl<'a> SurfaceTable<'a> {
    pub(super) fn new(asset: Asset<'a>, folder: &'a Folder<'a>, found: &'a [tobj::Material]) -> Self {
        Self {
            asset,
            folder,
            found,
            known: BTreeMap::new(),
            known_images: BTreeMap::new(),
            materials: Vec::new(),
            images: Vec::new(),
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
            Some(text) => Some(self.read_texture(&place, text, warnings)?),
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
        Ok(RawMaterial {
            name: name_or(Some(&found.name), || "material".to_owned()),
            base_color: [r, g, b, alpha],
            texture,
            alpha_cutoff,
            double_sided: false,
            unlit: false,
            flat_normals: false,
        })
    }

    fn read_texture(&mut self, place: &str, text: &str, warnings: &mut Warnings) -> Result<RawTexture> {
        let (clamp, ignored, name) = split_texture_options(text);
        let message = "texture options other than -clamp are ignored";
        warnings.add("texture-options-ignored", place, ignored, message);
        let wrap = if clamp { RawWrap::Clamp } else { RawWrap::Repeat };
        let here = format!("{place}: map_Kd `{}`", shorten(name));
        let image = match self.known_images.get(name) {
            Some(index) => *index,
            None => {
                let bytes = self.folder.read_path(&format!("{place}: map_Kd"), name)?;
                let file_name = name.rsplit(['/', '\\']).next().unwrap_or(name);
                self.images.push(read_image(self.asset, &here, shorten(file_name), bytes)?);
                let index = self.images.len() as u32 - 1;
                self.known_images.insert(name.to_owned(), index);
                index
            }
        };
        Ok(RawTexture { image, wrap_u: wrap, wrap_v: wrap })
    }
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
