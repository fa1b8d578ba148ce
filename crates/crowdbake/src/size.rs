//! How large a character is baked: as its file has it or as asked, and a word where the file seems to be in other units than metres.

use crate::error::Cause;
use crate::pose::pose_positions;
use crate::units::length;
use crate::views;
use crowd_source::{RawCharacter, RawProperty, Warning};

/// From this height at rest on a character is taken to be in other units, metres; the player shows it smaller (`crowdplay --height`).
const GIANT_M: f32 = 20.0;
/// From this height on rather in millimetres than in centimetres.
const MILLIMETRES_M: f32 = 1000.0;
/// A character that never reaches farther than this is one too, metres.
const DWARF_M: f32 = 0.02;
/// Coordinates beyond this are refused, metres, as the import does: floats are 6 cm apart there.
const FARTHEST_M: f32 = 1.0e6;

/// What a character's size is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SizeAsked {
    /// So many times that of the file.
    Factor(f32),
    /// So high at rest, metres.
    HeightM(f32),
}

/// Makes everything about a character so much larger or smaller: bind pose, tree and clips. Every pose stays what it is but for its size.
/// Gives back how many times.
///
/// # Errors
/// A height is asked for and there is none at rest, or coordinates end beyond what is allowed.
pub(crate) fn resize(raw: &mut RawCharacter, asked: SizeAsked) -> Result<f32, Cause> {
    let factor = match asked {
        SizeAsked::Factor(factor) => factor,
        SizeAsked::HeightM(height_m) => {
            let rest = crowd_anim::rest_clip(&views::skeleton_of(raw), &views::joints_of(raw))?;
            let posed = pose_positions(&raw.mesh.positions, &raw.mesh.joints, &raw.mesh.weights, &rest.palettes);
            let used = raw.mesh.triangles.iter().flatten().map(|&vertex| posed[vertex as usize]);
            let now_m = height_of(used);
            if now_m <= 0.0 {
                return Err(Cause::NoHeight);
            }
            height_m / now_m
        }
    };
    // A pose P becomes S P S^-1: a uniform scale leaves rotations and scales as they are.
    let lengths = (raw.mesh.positions.iter_mut().flatten())
        .chain(raw.nodes.iter_mut().flat_map(|node| &mut node.translation))
        .chain(raw.joints.iter_mut().chain(&mut raw.rig.joints).flat_map(|joint| &mut joint.inverse_bind[12..15]))
        .chain(raw.clips.iter_mut().flat_map(|clip| clip.tracks.iter_mut().chain(&mut clip.spare_tracks)).flat_map(
            |track| {
                let is_length = track.property == RawProperty::Translation;
                track.values.iter_mut().filter(move |_| is_length)
            },
        ));
    let mut farthest = 0.0_f32;
    for length in lengths {
        *length *= factor;
        // Of NaN and more than there is, the larger one is infinite.
        farthest = farthest.max(if length.is_nan() { f32::INFINITY } else { length.abs() });
    }
    if factor.is_finite() && farthest <= FARTHEST_M {
        return Ok(factor);
    }
    Err(Cause::Resize { factor })
}

/// The largest y less the smallest, 0 of none.
pub(crate) fn height_of(positions: impl Iterator<Item = [f32; 3]>) -> f32 {
    let (low, high) = positions.fold((f32::MAX, f32::MIN), |(low, high), [_, y, _]| (low.min(y), high.max(y)));
    (high - low).max(0.0)
}

/// Says so when a character is as high as a house, no larger than a beetle, or nothing at all. `radius_m`: of the sphere around it in all clips.
/// Code `unlikely-size`.
pub(crate) fn warn_of_size(height_m: f32, radius_m: f32) -> Option<Warning> {
    let (unit, factor) = if height_m >= MILLIMETRES_M {
        ("in millimetres", 0.001)
    } else if height_m >= GIANT_M {
        ("in centimetres", 0.01)
    } else if 2.0 * radius_m < 0.1 * DWARF_M {
        ("scaled down", 1000.0)
    } else if 2.0 * radius_m < DWARF_M {
        ("scaled down", 100.0)
    } else {
        return None;
    };
    let high = length(height_m);
    let message = if radius_m <= 0.0 {
        "all of it is at one place in every pose, so nothing is seen of it; is something above it scaled to 0?"
            .to_owned()
    } else if factor * 2.0 * radius_m < DWARF_M {
        format!("{high} high at rest and no larger in any clip; --height METRES bakes it as high as it should be")
    } else {
        let then = length(height_m * factor);
        format!(
            "{high} high at rest; if the file is {unit}, --scale {factor} bakes it {then} high; or say --height METRES"
        )
    };
    Some(Warning { code: "unlikely-size", place: "mesh".to_owned(), count: 1, message })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::bake_character;
    use crate::plan::PlanEntry;
    use std::path::Path;

    #[test]
    fn giants_and_dwarfs_are_warned_of_and_people_are_not() {
        let words = |height: f32| warn_of_size(height, 0.5 * height).map(|warning| warning.message);
        assert_eq!([19.9, 1.8, 0.1].map(words), [None, None, None]);
        let said = words(79.0).unwrap();
        assert!(said.contains("79.00 m high") && said.contains("--scale 0.01 bakes it 790 mm high"), "{said}");
        assert!(words(1800.0).unwrap().contains("--scale 0.001 bakes it 1.80 m"));
        assert!(words(0.018).unwrap().contains("--scale 100 bakes it 1.80 m"));
        assert!(words(0.0018).unwrap().contains("--scale 1000 "));
        assert_eq!(warn_of_size(0.001, 5.0), None, "a flat thing is not small");
        assert!(words(0.0).unwrap().contains("nothing is seen of it"));
        let said = words(1e-20).unwrap();
        assert!(said.contains("--height") && !said.contains("--scale"), "{said}");
    }

    #[test]
    fn a_resized_character_moves_as_before() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../fixtures/good/rigid_hat_should_follow_the_head_joint.glb");
        let bake = |size| bake_character(&PlanEntry { size, ..PlanEntry::of_file(&path) }, false, &|_, _| {});
        let (plain, halved) = (bake(None).unwrap(), bake(Some(SizeAsked::Factor(0.5))).unwrap());
        assert_eq!(halved.height_m, 0.5 * plain.height_m);
        assert_eq!(halved.order.collapse_map, plain.order.collapse_map);
        for (half, whole) in halved.clip_bounds.iter().zip(&plain.clip_bounds) {
            assert!((half.radius - 0.5 * whole.radius).abs() <= 1e-5 * whole.radius, "{half:?} {whole:?}");
        }
        let high = bake(Some(SizeAsked::HeightM(1.8))).unwrap();
        assert!((high.height_m - 1.8).abs() < 1e-4, "{}", high.height_m);
        let refusal = bake(Some(SizeAsked::HeightM(1.0e7))).unwrap_err().to_string();
        assert!(refusal.contains("1000000"), "{refusal}");
    }
}
