//! Which instances of a simulator can be drawn.

use crate::{FeedConfig, FeedState, InstanceRecord};
use crowd_pack::CharacterRecord;

/// The frame's instances from those that a simulator wrote, and what was taken.
///
/// The first `given_count` of `given` count, at most `feed.most`. Returns `feed.most` instances: whoever names a character or a
/// clip that is not there, or has a number that is not finite, becomes nobody (scale 0), and so does everyone past the count.
///
/// Twin: `shaders/stages/admit_instances.wgsl`. Equal.
pub fn admit_instances(
    characters: &[CharacterRecord],
    given: &[InstanceRecord],
    given_count: u32,
    feed: &FeedConfig,
) -> (Vec<InstanceRecord>, FeedState) {
    let nobody = InstanceRecord { clip: characters.first().map_or(0, |first| first.clip_offset), ..Default::default() };
    let count = given_count.min(feed.most);
    let is_sound = |one: &InstanceRecord| crate::data::check_instances(characters, std::slice::from_ref(one)).is_ok();
    let mut refused_count = given_count - count;
    let mut admitted = vec![nobody; feed.most as usize];
    for (place, one) in admitted.iter_mut().zip(&given[..count as usize]) {
        match is_sound(one) {
            true => *place = *one,
            false => refused_count += 1,
        }
    }
    (admitted, FeedState { count, refused_count })
}
