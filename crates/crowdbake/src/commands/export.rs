//! `crowdbake export`: which levels are asked for, and where each is written.

use crate::cli::{BakeOptions, ExportArgs};
use crate::error::{BakeError, Cause, DONE, Step};
use crate::output::{expect_folder_writable, expect_writable, refuse_inputs, write_whole};
use crate::talk::Talk;
use crate::unpack::{Unpacked, choose_character, open, triangle_target};
use crowd_pack::whole_file::folder_of;
use crowd_pack::{LodRecord, ManifestTarget};
use std::path::{Path, PathBuf};

pub(super) fn export(args: &ExportArgs, talk: &Talk<'_>) -> Result<u8, BakeError> {
    expect_outputs(args)?;
    let opened = open(&args.input, &BakeOptions::default())?;
    let contents = opened.contents();
    let character = Unpacked::new(contents, choose_character(contents, args.character.as_deref())?);
    // What the file will lack is said where it is written, too.
    let reduced = character.manifest.warnings.iter().filter(|warning| warning.starts_with("material-reduced"));
    reduced.for_each(|warning| talk.warn(format_args!("{}: {warning}", character.manifest.name)));
    if let Some(name) = &args.lod {
        return export_stored(args, &character, name, talk);
    }
    let wanted = wanted_levels(args, &character);
    // Whether every target is reached is known before the first file is written.
    let levels: Vec<(LodRecord, PathBuf)> = wanted
        .into_iter()
        .map(|wanted| choose_level(&character, &wanted, args.strict, talk).map(|level| (level, wanted.path)))
        .collect::<Result<_, _>>()?;
    levels.iter().try_for_each(|(_, path)| expect_output(args, path))?;
    for (level, path) in &levels {
        let (bytes, level) = match args.refit {
            true => crate::export::export_refitted(&character, *level),
            false => crate::export::export_level(&character, *level),
        };
        write_whole(path, &bytes)?;
        talk.note(format_args!(
            "{}: {} triangles, {} vertices",
            path.display(),
            level.triangle_count,
            level.vertex_count
        ));
    }
    Ok(DONE)
}

/// Sees before the bake what the words alone say: every file where they name it, the folder where names come with the character.
fn expect_outputs(args: &ExportArgs) -> Result<(), BakeError> {
    match (&args.lods, args.lod.as_deref()) {
        _ if is_folder(&args.output) => expect_folder_writable(&args.output),
        (_, Some("all")) => expect_folder_writable(folder_of(&args.output)),
        (Some(ratios), _) => {
            (0..ratios.len()).try_for_each(|index| expect_output(args, &lod_path(&args.output, "", index)))
        }
        _ => expect_output(args, &args.output),
    }
}

fn expect_output(args: &ExportArgs, path: &Path) -> Result<(), BakeError> {
    refuse_inputs(path, std::slice::from_ref(&args.input))?;
    expect_writable(path)
}

/// Writes the discrete level of that name, or all of them.
fn export_stored(args: &ExportArgs, character: &Unpacked<'_>, name: &str, talk: &Talk<'_>) -> Result<u8, BakeError> {
    let discrete = &character.manifest.discrete;
    let chosen: Vec<usize> = (0..discrete.len()).filter(|&i| name == "all" || discrete[i].name == name).collect();
    if chosen.is_empty() {
        let names: Vec<&str> = discrete.iter().map(|level| level.name.as_str()).collect();
        let found = if names.is_empty() { "no discrete level".to_owned() } else { names.join(", ") };
        let cause = Cause::LevelNotFound { asked: name.to_owned(), found };
        return Err(BakeError::of(Step::ChooseLevel, &character.manifest.name, cause));
    }
    if let (true, Some(missed)) = (args.strict, chosen.iter().find(|&&i| !discrete[i].reached)) {
        return Err(BakeError::of(Step::ChooseLevel, &character.manifest.name, missed_stored(character, *missed)));
    }
    let path_of = |index: usize| match name {
        "all" => stored_path(&args.output, &character.manifest.name, &discrete[index].name),
        _ if is_folder(&args.output) => stored_path(&args.output, &character.manifest.name, name),
        _ => args.output.clone(),
    };
    chosen.iter().try_for_each(|&index| expect_output(args, &path_of(index)))?;
    for index in chosen {
        let path = path_of(index);
        let level = &character.discrete_levels()[index];
        if !discrete[index].reached {
            talk.warn(format_args!("{}: {}", character.manifest.name, missed_stored(character, index)));
        }
        let refitted = if level.is_refit() { ", refitted" } else { "" };
        let (bytes, level) = crate::export::export_stored(character, level);
        write_whole(&path, &bytes)?;
        talk.note(format_args!(
            "{}: {} triangles, {} vertices{refitted}",
            path.display(),
            level.triangle_count,
            level.vertex_count
        ));
    }
    Ok(DONE)
}

fn missed_stored(character: &Unpacked<'_>, index: usize) -> Cause {
    let discrete = &character.manifest.discrete[index];
    let asked = match discrete.target {
        ManifestTarget::Ratio(share) => triangle_target(character.record.triangle_count, f64::from(share)),
        _ => discrete.measured.triangle_count,
    };
    Cause::TargetMissed {
        what: "triangles",
        asked: asked.into(),
        coarsest: character.record.min_triangle_count.into(),
        blocked: character.blocked(),
    }
}

/// `OUT.glb` becomes `OUT.lod1.glb`; a folder gets `NAME.lod1.glb`.
fn stored_path(output: &Path, character: &str, level: &str) -> PathBuf {
    let ending = format!("{}.glb", file_name(level));
    if is_folder(output) {
        return output.join(format!("{}.{ending}", file_name(character)));
    }
    output.with_extension(ending)
}

/// A level asked for, and where it goes.
struct Wanted {
    what: &'static str,
    at_most: u32,
    path: PathBuf,
}

fn wanted_levels(args: &ExportArgs, character: &Unpacked<'_>) -> Vec<Wanted> {
    let full = character.record.triangle_count;
    let single = |what, at_most| {
        let path = if is_folder(&args.output) {
            args.output.join(format!("{}.glb", file_name(&character.manifest.name)))
        } else {
            args.output.clone()
        };
        vec![Wanted { what, at_most, path }]
    };
    if let Some(triangles) = args.triangles {
        return single("triangles", triangles);
    }
    if let Some(vertices) = args.vertices {
        return single("vertices", vertices);
    }
    if let Some(ratio) = args.ratio {
        return single("triangles", triangle_target(full, ratio));
    }
    let ratios = args.lods.iter().flatten().enumerate();
    let wanted = ratios.map(|(index, &ratio)| Wanted {
        what: "triangles",
        at_most: triangle_target(full, ratio),
        path: lod_path(&args.output, &character.manifest.name, index),
    });
    wanted.collect()
}

/// `OUT.glb` becomes `OUT.lod0.glb`; a folder gets `NAME.lod0.glb`.
fn lod_path(output: &Path, name: &str, index: usize) -> PathBuf {
    if is_folder(output) {
        return output.join(format!("{}.lod{index}.glb", file_name(name)));
    }
    output.with_extension(format!("lod{index}.glb"))
}

/// A folder, or the name of one that is to be made.
fn is_folder(output: &Path) -> bool {
    output.is_dir() || output.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
}

/// A name from a pack as a file name: nothing that leaves the folder.
fn file_name(name: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_alphanumeric() || "-_. ".contains(c) { c } else { '_' }).collect();
    let name = name.trim_start_matches('.').to_owned();
    if name.is_empty() { "character".to_owned() } else { name }
}

fn choose_level(
    character: &Unpacked<'_>,
    wanted: &Wanted,
    strict: bool,
    talk: &Talk<'_>,
) -> Result<LodRecord, BakeError> {
    let count = |level: LodRecord| if wanted.what == "vertices" { level.vertex_count } else { level.triangle_count };
    let (level, reached) = character.largest_level(|level| count(level) <= wanted.at_most);
    if reached {
        return Ok(level);
    }
    let missed = Cause::TargetMissed {
        what: wanted.what,
        asked: wanted.at_most.into(),
        coarsest: count(level).into(),
        blocked: character.blocked(),
    };
    if strict {
        return Err(BakeError::of(Step::ChooseLevel, &character.manifest.name, missed));
    }
    talk.warn(format_args!("{}: {missed}", character.manifest.name));
    Ok(level)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_a_pack_stay_in_the_folder() {
        assert_eq!(file_name("../../etc/passwd"), "_.._etc_passwd");
        assert_eq!(file_name(".."), "character");
        assert_eq!(lod_path(Path::new("out/k.glb"), "k", 2), Path::new("out/k.lod2.glb"));
        assert_eq!(lod_path(Path::new("new/"), "k 1", 0), Path::new("new/k 1.lod0.glb"));
        assert_eq!(is_folder(Path::new("new\\")), cfg!(windows), "elsewhere it is part of a name");
    }
}
