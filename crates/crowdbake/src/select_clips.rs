//! Which clips a bake keeps, and which a weight is for: by name or pattern.

use crate::bake::BakedCharacter;
use crate::error::{BakeError, Cause};
use crate::plan::PlanEntry;
use crowd_source::RawClip;
use std::collections::BTreeSet;

/// Clips whose name equals one of `patterns` or matches it. A name must be there. A pattern may match nothing, as one list serves
/// characters of many hands, as long as another keeps a clip.
pub(crate) fn select_clips(clips: Vec<RawClip>, patterns: &[String]) -> Result<Vec<RawClip>, Cause> {
    let mut kept = vec![false; clips.len()];
    let mut refused = None;
    for asked in patterns {
        let names = clips.iter().map(|clip| clip.name.as_str());
        match matching_clips(names, asked) {
            Ok(found) => found.into_iter().for_each(|index| kept[index] = true),
            Err(cause) if is_pattern(asked) && glob::Pattern::new(asked).is_ok() => refused = refused.or(Some(cause)),
            Err(cause) => return Err(cause),
        }
    }
    match refused {
        Some(cause) if !kept.contains(&true) => Err(cause),
        _ => Ok(clips.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|(clip, _)| clip).collect()),
    }
}

/// Patterns that found no clip in any of the characters that were to keep what they find; none of those of a character that was refused, whose
/// clips are not known.
pub(crate) fn patterns_without_clips(
    entries: &[PlanEntry],
    results: &[Result<BakedCharacter, BakeError>],
) -> BTreeSet<String> {
    let mut idle = BTreeSet::new();
    let mut useful = BTreeSet::new();
    for (entry, result) in entries.iter().zip(results) {
        for asked in entry.clips.iter().flatten().filter(|asked| is_pattern(asked)) {
            let found = result.as_ref().map(|baked| {
                let names = baked.raw.clips.iter().map(|clip| clip.name.as_str());
                matching_clips(names, asked).is_ok()
            });
            let set = if found.unwrap_or(true) { &mut useful } else { &mut idle };
            set.insert(asked.clone());
        }
    }
    &idle - &useful
}

/// Whether `asked` stands for more than one name.
fn is_pattern(asked: &str) -> bool {
    asked.contains(['*', '?', '['])
}

/// Indices of the clips whose name equals `asked` or matches it; at least one.
pub(crate) fn matching_clips<'a>(
    names: impl Iterator<Item = &'a str> + Clone,
    asked: &str,
) -> Result<Vec<usize>, Cause> {
    let pattern = glob::Pattern::new(asked).ok().filter(|_| is_pattern(asked));
    // Files of many hands say `walk`, `Walk` and `Armature|Walk`.
    let any_case = glob::MatchOptions { case_sensitive: false, ..Default::default() };
    let matches =
        |name: &str| name == asked || pattern.as_ref().is_some_and(|pattern| pattern.matches_with(name, any_case));
    let found: Vec<usize> = names.clone().enumerate().filter(|(_, name)| matches(name)).map(|(i, _)| i).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let names: Vec<&str> = names.collect();
    let found = match names.len() {
        0 => "no clips at all".to_owned(),
        // A file of a hundred clips would bury what was asked.
        count if count > 24 => format!("{} and {} more", names[..20].join(", "), count - 20),
        _ => names.join(", "),
    };
    Err(Cause::ClipNotFound { asked: asked.to_owned(), found })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clips(names: &[&str]) -> Vec<RawClip> {
        names
            .iter()
            .map(|name| RawClip { name: (*name).to_owned(), tracks: Vec::new(), spare_tracks: Vec::new() })
            .collect()
    }

    #[test]
    fn clips_keep_their_order_and_every_name_must_be_there() {
        let all = || clips(&["Idle", "Walking_A", "Run", "Walking_B", "odd[name]"]);
        let kept = select_clips(all(), &["Run".into(), "Walk*".into(), "odd[name]".into()]).unwrap();
        assert_eq!(
            kept.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
            ["Walking_A", "Run", "Walking_B", "odd[name]"]
        );
        let refusal = select_clips(all(), &["Idle".into(), "Swim".into()]).unwrap_err().to_string();
        assert!(refusal.contains("`Swim`") && refusal.contains("Walking_A"), "{refusal}");
        // A pattern goes by letters in any case, and may find nothing where another finds something.
        let kept = select_clips(all(), &["*walk*".into(), "*swim*".into()]).unwrap();
        assert_eq!(kept.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["Walking_A", "Walking_B"]);
        let refusal = select_clips(all(), &["*swim*".into(), "*fly*".into()]).unwrap_err().to_string();
        assert!(refusal.contains("`*swim*`"), "{refusal}");
        assert!(select_clips(all(), &["run".into()]).is_err(), "a name is a name");
        assert!(select_clips(all(), &["*walk*".into(), "**run**".into()]).is_err(), "no pattern at all");
        let many: Vec<String> = (0..76).map(|n| format!("clip{n}")).collect();
        let refusal = select_clips(clips(&many.iter().map(String::as_str).collect::<Vec<_>>()), &["Idle".into()]);
        let refusal = refusal.unwrap_err().to_string();
        assert!(refusal.contains("clip19 and 56 more") && !refusal.contains("clip20"), "{refusal}");
        assert!(select_clips(Vec::new(), &["Idle".into()]).unwrap_err().to_string().contains("no clips at all"));
    }
}
