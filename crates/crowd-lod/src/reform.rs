//! Makes the triangles of a level (Peng 2011 §5.2).

/// The triangles of the prefix with `vertex_count` vertices: the first `triangle_count` triangles with every index looked
/// up in the collapse map until it is below `vertex_count`.
///
/// `collapse_map`: as in [`crate::CollapseOrder`], each entry at most its own index. `vertex_count` and
/// `triangle_count` are those of one [`crate::Level`]; then no triangle returned is degenerate. More triangles than there
/// are, and indices outside the map, are left out; an index that maps to itself stays.
///
/// Paper: Peng 2011 §5.2, triangle reformation.
pub fn reform(triangles: &[[u32; 3]], collapse_map: &[u32], vertex_count: u32, triangle_count: u32) -> Vec<[u32; 3]> {
    // Each vertex's place in this level: the map is walked once for all, coarse first.
    let mut place: Vec<u32> = Vec::with_capacity(collapse_map.len());
    for (v, &target) in collapse_map.iter().enumerate() {
        let settled = (v as u32) < vertex_count || target as usize >= v;
        place.push(if settled { v as u32 } else { place[target as usize] });
    }
    let in_map = |t: &&[u32; 3]| t.iter().all(|&v| (v as usize) < place.len());
    let chosen = triangles.iter().take(triangle_count as usize).filter(in_map);
    chosen.map(|t| t.map(|v| place[v as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::reform;

    #[test]
    fn looks_up_until_below_the_count() {
        // 4 -> 3 -> 1; triangle 1 vanishes with vertex 3.
        let triangles = [[0, 1, 2], [0, 3, 4], [2, 4, 0]];
        let map = [0, 1, 2, 1, 3];
        assert_eq!(reform(&triangles, &map, 5, 3), triangles);
        assert_eq!(reform(&triangles, &map, 4, 1), [[0, 1, 2]]);
        assert_eq!(reform(&[[2, 4, 0]], &map, 4, 1), [[2, 3, 0]]);
        assert_eq!(reform(&[[2, 4, 0]], &map, 3, 1), [[2, 1, 0]]);
    }

    #[test]
    fn hostile_maps_and_counts_do_no_harm() {
        let triangles = [[0, 1, 2], [0, 9, 2]];
        assert_eq!(reform(&triangles, &[7, 7, 7], 0, 100), [[0, 1, 2]]);
        assert!(reform(&triangles, &[], 3, 2).is_empty());
        assert!(reform(&[], &[0, 0], 1, 1).is_empty());
    }
}
