//! Instances of a bucket side by side.

/// Numbers of the instances, sorted by key; equal keys stay in the instances' order. Returns the sorted keys, too.
///
/// Paper: Park & Han 2009 §3.2, the second phase, there one geometry-shader pass per LOD. Departs: one stable sort by digits,
/// its places from prefix sums, so the order is fixed.
/// Twin: `shaders/stages/sort_instances.wgsl`. Equal.
pub fn sort_instances(keys: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut sorted: Vec<u32> = (0..keys.len() as u32).collect();
    sorted.sort_by_key(|i| keys[*i as usize]);
    (sorted.iter().map(|i| keys[*i as usize]).collect(), sorted)
}
