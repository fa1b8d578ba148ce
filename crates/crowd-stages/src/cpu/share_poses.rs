//! Palettes and vertices of leaders, for all who follow them.

use crate::{BucketPlace, BucketRange, Buckets, DrawnInstance, InstanceBase};
use crowd_pack::NONE;

/// The leaders of each bucket, as `ranges` has its instances. Entry point `range_leaders`.
///
/// `leaders_before`, `end`: leaders before each entry and in all, of [`super::scan_counts`].
pub fn range_leaders(ranges: &[BucketRange], leaders_before: &[InstanceBase], end: InstanceBase) -> Vec<BucketRange> {
    let before = |entry: u32| leaders_before.get(entry as usize).unwrap_or(&end).vertex_base;
    let of = |range: &BucketRange| match range.end == range.first {
        true => BucketRange::default(),
        false => BucketRange { first: before(range.first), end: before(range.end) },
    };
    ranges.iter().map(of).collect()
}

/// Sends everyone drawn to the palette and the vertices of their leader; the entry of each leader. Entry point `follow_leaders`.
///
/// `places`: of `place_buckets`, of the leaders of each bucket. `drawn`: of `gather_drawn`; only leaders keep rows to blend.
///
/// Paper: Lister et al. 2010, a cache of skinned key poses. Departs: nothing is kept from frame to frame; who shares a pose in this
/// one does so by its place in the sorted list. Twin: `shaders/stages/share_poses.wgsl`. Equal.
pub fn follow_leaders(
    buckets: &Buckets,
    sorted_keys: &[u32],
    leaders_before: &[InstanceBase],
    end: InstanceBase,
    places: &[BucketPlace],
    drawn: &mut [DrawnInstance],
) -> Vec<u32> {
    let mut leaders = Vec::new();
    for (entry, one) in drawn.iter_mut().enumerate() {
        let up_to = leaders_before.get(entry + 1).unwrap_or(&end).vertex_base;
        let leader = up_to - 1;
        let place = places[sorted_keys[entry] as usize];
        // Impostors have other words there.
        if sorted_keys[entry] < buckets.first_impostor {
            one.palette_row = buckets.palette_row(leader);
            if place.vertex_base != NONE {
                one.vertex_base = place.vertex_base + (leader - place.first) * place.vertex_count;
            }
        }
        if up_to > leaders_before[entry].vertex_base {
            leaders.push(entry as u32);
        } else {
            one.row_count = 0;
        }
    }
    leaders
}
