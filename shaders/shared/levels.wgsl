// What a stage asks the quantised levels that it has bound as `buckets`. Twin: Buckets::level_of in crowd-stages/src/buckets.rs.

// The finest of a character's levels with at most so many vertices; 0, the coarsest, where all have more.
fn level_of(levels: BucketSet, vertex_count: u32) -> u32 {
    var low = 0u;
    var high = levels.level_count;
    while low + 1u < high {
        let middle = (low + high) / 2u;
        if buckets[bucket_of_level(levels, middle)].vertex_count <= vertex_count {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}
