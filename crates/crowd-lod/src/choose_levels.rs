//! Chooses levels of an order in geometric steps of their triangle counts.

use crate::Level;

/// Indices, rising, of at most `count` levels: the coarsest, full detail, and between them about equal ratios of triangles.
///
/// `levels`: coarsest first, as in [`crate::CollapseOrder::levels`]. Where companions or small meshes leave no level near a
/// step, steps fall together and fewer come back. Each chosen level has more triangles than the one before; full detail is
/// always the last, the coarsest the first.
pub fn geometric_levels(levels: &[Level], count: usize) -> Vec<usize> {
    let (Some(first), Some(last)) = (levels.first(), levels.last()) else { return Vec::new() };
    let least = f64::from(first.triangle_count.max(1));
    let ratio = f64::from(last.triangle_count.max(1)) / least;
    let mut chosen: Vec<usize> = vec![0];
    for step in 1..count.max(2) - 1 {
        let wanted = least * libm::pow(ratio, step as f64 / (count.max(2) - 1) as f64);
        let level = levels.partition_point(|level| f64::from(level.triangle_count) <= wanted + 0.5).max(1) - 1;
        let more = |chosen: &[usize]| levels[level].triangle_count > levels[chosen[chosen.len() - 1]].triangle_count;
        if level + 1 < levels.len() && levels[level].triangle_count < last.triangle_count && more(&chosen) {
            chosen.push(level);
        }
    }
    if levels.len() > 1 {
        chosen.push(levels.len() - 1);
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(triangles: impl IntoIterator<Item = u32>) -> Vec<Level> {
        let level = |triangle_count| Level { vertex_count: triangle_count, triangle_count, error_m: 0.0 };
        triangles.into_iter().map(level).collect()
    }

    #[test]
    fn steps_are_of_one_ratio() {
        let all = levels(100..=5_600);
        let chosen = geometric_levels(&all, 64);
        assert_eq!(chosen.len(), 64);
        assert_eq!((chosen[0], chosen[63]), (0, all.len() - 1));
        let step = libm::pow(56.0, 1.0 / 63.0);
        for pair in chosen.windows(2) {
            let ratio = f64::from(all[pair[1]].triangle_count) / f64::from(all[pair[0]].triangle_count);
            assert!((ratio / step - 1.0).abs() < 0.011, "{ratio}");
        }
    }

    #[test]
    fn few_levels_are_listed_once() {
        assert_eq!(geometric_levels(&levels([2, 4, 6]), 64), [0, 1, 2]);
        assert_eq!(geometric_levels(&levels([2, 90, 91, 100]), 3), [0, 3]);
        assert_eq!(geometric_levels(&levels([7]), 64), [0]);
        assert_eq!(geometric_levels(&levels([0, 5]), 64), [0, 1]);
        // More vertices and no more triangles is no step.
        assert_eq!(geometric_levels(&levels([4, 4, 4, 8, 8]), 64), [0, 4]);
        assert!(geometric_levels(&[], 64).is_empty());
    }
}
