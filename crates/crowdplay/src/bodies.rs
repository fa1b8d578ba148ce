//! How much room characters take, and what follows: how far apart they stand, and who walks where people walk.

use crate::crowd::list;
use crowd_scene::Kind;
use crowd_stages::{CrowdData, InstanceRecord, LodChoice, cpu};

/// What a layout needs to know of a character that plays these clips and is shown at that factor of its size.
pub(crate) fn kind(data: &CrowdData, character: u32, clips: &[u32], factor: f32) -> Kind {
    let record = &data.characters[character as usize];
    let durations =
        (0..record.clip_count.max(1)).map(|i| data.clips[(record.clip_offset + i) as usize].duration_s).collect();
    Kind { footprint_m: factor * footprint_m(data, character, clips), clip_durations_s: durations, ..Kind::default() }
}

/// Radius on the ground that holds nine tenths of the coarsest level's vertices at the start and in the middle of the
/// clips that play: the body, not the tip of its sword.
fn footprint_m(data: &CrowdData, character: u32, clips: &[u32]) -> f32 {
    let record = &data.characters[character as usize];
    let choice = LodChoice { vertex_count: record.min_vertex_count, triangle_count: record.min_triangle_count };
    let mut greatest = 0.01f32;
    for &clip in clips.iter().take(8) {
        let clip = record.clip_offset + clip;
        let instance = InstanceRecord { scale: 1.0, character, clip, ..Default::default() };
        for time_s in [0.0, 0.5 * data.clips[clip as usize].duration_s] {
            let posed = cpu::pose_instance(data, &instance, choice, time_s);
            let mut radii: Vec<f32> = posed.positions.iter().map(|&[x, _, z]| (x * x + z * z).sqrt()).collect();
            radii.sort_by(f32::total_cmp);
            greatest = radii.get(radii.len() * 9 / 10).copied().unwrap_or(0.0).max(greatest);
        }
    }
    greatest
}

/// Room for everyone: a little between the widest, and where all are about as wide enough to stand out of line.
pub(crate) fn usual_spacing(kinds: &[Kind]) -> f32 {
    let widest = kinds.iter().map(|kind| kind.footprint_m).fold(0.01, f32::max);
    let mean = kinds.iter().map(|kind| kind.footprint_m).sum::<f32>() / kinds.len().max(1) as f32;
    (2.1 * widest).max(2.5 * mean)
}

/// What is said where a spacing was too small for the characters.
pub(crate) fn raised(asked_m: f32, used_m: f32, kinds: &[Kind]) -> Option<String> {
    let widest = kinds.iter().max_by(|a, b| a.footprint_m.total_cmp(&b.footprint_m))?;
    (used_m > asked_m * 1.0001).then(|| {
        format!(
            "--spacing {asked_m}: raised to {used_m:.2} m so that nobody stands in another ({} is {:.2} m across)",
            widest.name,
            2.0 * widest.footprint_m
        )
    })
}

/// Whoever is wider is no pedestrian, as a radius: half of what people on a walk keep between them.
const WALKERS_M: f32 = 0.6;

/// Of the characters those whom a simulator's people or a walk are cast with: the ways were made for people, and whoever is much wider would
/// walk through others. Characters that were named all stay, and so do all where nobody is narrow enough; it is said who does.
pub(crate) fn who_walks(kinds: &[Kind], are_named: bool, remarks: &mut Vec<String>) -> Vec<bool> {
    let is_narrow: Vec<bool> = kinds.iter().map(|kind| kind.footprint_m <= WALKERS_M).collect();
    let wide = kinds.iter().zip(&is_narrow).filter(|(_, narrow)| !**narrow);
    let wide: Vec<String> = wide.map(|(kind, _)| format!("{} ({:.1} m)", kind.name, 2.0 * kind.footprint_m)).collect();
    if wide.is_empty() {
        return is_narrow;
    }
    let (wide, room_m) = (list(wide.iter().map(String::as_str)), 2.0 * WALKERS_M);
    if are_named || !is_narrow.contains(&true) {
        remarks.push(format!("{wide}: wider than the {room_m} m that ways are made for; they may walk through others"));
        return vec![true; kinds.len()];
    }
    remarks.push(format!(
        "{wide}: not among those who walk, wider than {room_m} m (--characters NAME,... takes whom it names)"
    ));
    is_narrow
}

/// Those of a list that stay.
pub(crate) fn kept<T>(all: Vec<T>, stays: &[bool]) -> Vec<T> {
    all.into_iter().zip(stays).filter(|(_, stays)| **stays).map(|(one, _)| one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_is_much_wider_than_a_person_walks_only_when_named() {
        let kinds: Vec<Kind> = [("ada", 0.4), ("zebra", 1.0), ("bob", 0.3)]
            .map(|(name, footprint_m)| Kind { name: name.into(), footprint_m, ..Kind::default() })
            .into();
        let mut remarks = Vec::new();
        assert_eq!(who_walks(&kinds, false, &mut remarks), [true, false, true]);
        assert!(remarks[0].contains("zebra (2.0 m)") && remarks[0].contains("--characters"), "{remarks:?}");
        assert_eq!(who_walks(&kinds, true, &mut remarks), [true; 3]);
        assert_eq!(who_walks(&kinds[1..2], false, &mut remarks), [true]);
        assert!(remarks[1..].iter().all(|said| said.contains("zebra") && said.contains("through others")));
        remarks.clear();
        assert_eq!(who_walks(&kinds[..1], false, &mut remarks), [true]);
        assert!(remarks.is_empty());
    }

    #[test]
    fn a_spacing_below_the_bodies_is_said() {
        let kinds = [Kind { name: "ada".into(), footprint_m: 0.5, ..Kind::default() }];
        let said = raised(0.3, 1.0, &kinds).expect("it was raised");
        assert!(said.contains("--spacing 0.3") && said.contains("1.00 m") && said.contains("ada"), "{said}");
        assert_eq!(raised(1.0, 1.0, &kinds), None);
    }
}
