//! Refuses what the rest of the crate would trip over.

use crate::evaluate_track::{floats_per_value, parts_per_key};
use crate::{ClipView, Error, Joint, Result, Skeleton, TrackView};

/// Indices within range, parents first, finite numbers.
pub(crate) fn check_skeleton(skeleton: &Skeleton, joints: &[Joint]) -> Result<()> {
    let (nodes, rests) = (skeleton.parents.len(), skeleton.rest.len());
    expect(nodes == rests, || "rest transforms".to_owned(), || rests.to_string(), || format!("{nodes}, one a node"))?;
    for (node, (parent, rest)) in skeleton.parents.iter().zip(&skeleton.rest).enumerate() {
        if let Some(parent) = *parent {
            let fits = (parent as usize) < node;
            expect(fits, || format!("node {node}: parent"), || parent.to_string(), || format!("below {node}"))?;
        }
        let finite = rest.translation.is_finite() && rest.rotation.is_finite() && rest.scale.is_finite();
        expect(finite, || format!("node {node}: rest"), || format!("{rest:?}"), || "finite numbers".to_owned())?;
    }
    for (index, joint) in joints.iter().enumerate() {
        let fits = (joint.node as usize) < nodes;
        expect(fits, || format!("joint {index}: node"), || joint.node.to_string(), || format!("below {nodes}"))?;
        let found = || format!("{:?}", joint.inverse_bind);
        let what = || format!("joint {index}: inverse bind matrix");
        expect(joint.inverse_bind.is_finite(), what, found, || "finite numbers".to_owned())?;
    }
    Ok(())
}

/// Every track has a node, rising times and the values they need.
pub(crate) fn check_clip(skeleton: &Skeleton, clip: &ClipView<'_>) -> Result<()> {
    for (index, track) in clip.tracks.iter().enumerate() {
        let what = |field: &str| format!("clip `{}`: track {index}: {field}", clip.name.escape_debug());
        check_track(skeleton.parents.len(), track, &what)?;
    }
    Ok(())
}

fn check_track(nodes: usize, track: &TrackView<'_>, what: &dyn Fn(&str) -> String) -> Result<()> {
    expect((track.node as usize) < nodes, || what("node"), || track.node.to_string(), || format!("below {nodes}"))?;
    expect(!track.times.is_empty(), || what("keys"), || "0".to_owned(), || "at least 1".to_owned())?;
    let rising = track.times.iter().all(|t| t.is_finite()) && track.times.windows(2).all(|pair| pair[0] < pair[1]);
    expect(rising, || what("times"), || "other numbers".to_owned(), || "finite, strictly increasing".to_owned())?;
    let floats = floats_per_value(track.property) * parts_per_key(track.interpolation);
    let allowed = || format!("{floats} for each of {} keys", track.times.len());
    let fits = track.times.len().checked_mul(floats) == Some(track.values.len());
    expect(fits, || what("values"), || track.values.len().to_string(), allowed)?;
    let finite = track.values.iter().all(|v| v.is_finite());
    expect(finite, || what("values"), || "others".to_owned(), || "finite numbers".to_owned())
}

/// [`Error::Parameter`] unless `holds`.
pub(crate) fn expect(
    holds: bool,
    what: impl FnOnce() -> String,
    found: impl FnOnce() -> String,
    allowed: impl FnOnce() -> String,
) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::Parameter { what: what(), found: found(), allowed: allowed() }) }
}
