//! What a bake says of its levels: reached, missed, repeated, too fine for a far crowd.

use crate::assemble::assemble;
use crate::bake::BakedCharacter;
use crate::bake_levels::level_name;
use crate::error::Cause;
use crate::talk::Talk;
use crate::unpack::{Unpacked, triangle_target};
use crowd_pack::{AnimationLayout, ManifestTarget};
use crowd_source::Warning;

/// A coarsest level above this share of the triangles, and above this many of them, is worth a warning: a far crowd
/// member should cost little.
const FLOOR_SHARE: f64 = 0.1;
/// See [`FLOOR_SHARE`].
const FLOOR_TRIANGLES: u32 = 128;

/// With `--strict`, a level that does not reach its target refuses the character.
pub(crate) fn expect_reached(baked: &BakedCharacter) -> Result<(), Cause> {
    let order = &baked.order;
    let levels = &baked.levels;
    let stored = levels.discrete.iter().map(|discrete| (discrete.target, discrete.reached));
    let mut all = stored.chain(levels.repeated.iter().map(|repeated| (repeated.target, repeated.reached)));
    let Some((missed, _)) = all.find(|(_, reached)| !reached) else { return Ok(()) };
    let ManifestTarget::Ratio(share) = missed.0 else { return Ok(()) };
    Err(Cause::TargetMissed {
        what: "triangles",
        asked: triangle_target(order.triangles.len() as u32, f64::from(share)).into(),
        coarsest: order.levels.first().map_or(0, |level| level.triangle_count).into(),
        blocked: blocked_where(baked),
    })
}

/// What keeps the coarsest level from going further, and where, in words: as whoever opens the pack would say it.
fn blocked_where(baked: &BakedCharacter) -> String {
    match assemble(std::slice::from_ref(baked), AnimationLayout::default()) {
        Ok(contents) => Unpacked::new(&contents, 0).blocked(),
        // The character is refused for that a little later; until then the counts must do.
        Err(_) => {
            let b = baked.order.blocked;
            blocked_sentence(b.fixed, b.seam, b.topology, b.flip, b.ended)
        }
    }
}

/// Says so when the coarsest level is far from a crowd's far field, and why.
pub(crate) fn warn_of_high_floor(baked: &BakedCharacter) -> Option<Warning> {
    let order = &baked.order;
    let (coarsest, full) = (order.levels.first()?.triangle_count, order.levels.last()?.triangle_count);
    let ended = order.blocked.ended > 0;
    if ended || f64::from(coarsest) <= f64::from(full) * FLOOR_SHARE || coarsest <= FLOOR_TRIANGLES {
        return None;
    }
    Some(Warning {
        code: "coarsest-level-high",
        place: "mesh".to_owned(),
        count: coarsest.into(),
        message: format!(
            "the coarsest level keeps {coarsest} of {full} triangles ({:.0} %); {}",
            100.0 * f64::from(coarsest) / f64::from(full),
            blocked_where(baked)
        ),
    })
}

/// One warning a level asked for that is not stored, since it is another one.
pub(crate) fn warn_of_repeats(baked: &BakedCharacter) -> Vec<Warning> {
    let levels = &baked.levels;
    let warn = |repeated: &crate::bake_levels::RepeatedLevel| Warning {
        code: "level-repeated",
        place: repeated.target.to_string(),
        count: 1,
        message: match repeated.same_as {
            Some(number) => format!(
                "the level `{}` comes out as {} ({}) and is stored once",
                repeated.target.words(),
                level_name(number),
                levels.discrete[number].target.words()
            ),
            None => format!(
                "no level of the order is `{}` but full detail, which is not stored again; allow more",
                repeated.target.words()
            ),
        },
    };
    levels.repeated.iter().map(warn).collect()
}

/// What keeps the coarsest level from going further, in words.
pub fn blocked_sentence(fixed: u32, seam: u32, topology: u32, flip: u32, ended: u32) -> String {
    if ended > 0 {
        return format!(
            "nothing holds it: the detail was ended there, {ended} positions could still move; see --coarsest"
        );
    }
    format!(
        "positions that cannot move: {fixed} on open borders or of class fixed, {seam} on seams without a partner, \
         {topology} that would change the topology, {flip} that would flip a triangle"
    )
}

/// One line a discrete level: asked for, got, reached or what holds it.
pub(crate) fn say_levels(talk: &Talk<'_>, baked: &BakedCharacter) {
    let full = f64::from(baked.order.levels.last().map_or(1, |level| level.triangle_count.max(1)));
    for discrete in &baked.levels.discrete {
        let triangles = discrete.level.indices.len() / 3;
        let refitted = if discrete.level.own.is_some() { ", refitted" } else { "" };
        talk.note(format_args!(
            "  {} ({}): {} triangles ({:.1} %), RMS {:.1} mm, every point within {:.1} mm{refitted}: {}",
            discrete.name,
            discrete.target.words(),
            triangles,
            100.0 * triangles as f64 / full,
            f64::from(discrete.level.error.surface.rms_m) * 1e3,
            f64::from(discrete.level.error.surface.bound_m) * 1e3,
            if discrete.reached { "reached" } else { "not reached" },
        ));
        if !discrete.reached {
            let held = blocked_where(baked);
            talk.warn(format_args!(
                "{}: {} is not reached; {held}; `crowdbake explain` says what to change",
                baked.name, discrete.name
            ));
        }
    }
}
