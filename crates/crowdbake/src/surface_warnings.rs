//! Says what the simplifier dropped from a mesh, and what about its surface will hold it back.

use crowd_lod::SeamReport;
use crowd_source::Warning;

/// One warning per kind of oddity found, with its count.
///
/// | code | what it means |
/// |---|---|
/// | `degenerate-triangles-dropped` | two corners at one place: nothing is seen of them |
/// | `duplicate-triangles-dropped` | another triangle has the same corners, attributes and front |
/// | `coincident-triangles` | same three places as another one, other front or attributes: kept |
/// | `non-manifold-edges` | edges with more than two triangles: kept |
/// | `non-manifold-positions` | surfaces that meet in a point or on such an edge: kept |
/// | `hurried-collapses` | collapses onto places with very many triangles, taken in turn instead of by cost |
pub(crate) fn warn_of_surface(seams: &SeamReport) -> Vec<Warning> {
    let kinds: [(&'static str, u32, &str); 6] = [
        (
            "degenerate-triangles-dropped",
            seams.degenerate_triangle_count,
            "triangles with two corners at one place were left out; nothing is seen of them",
        ),
        (
            "duplicate-triangles-dropped",
            seams.duplicate_triangle_count,
            "triangles that repeat another one, corner by corner, were left out; nothing is seen of them",
        ),
        (
            "coincident-triangles",
            seams.coincident_triangle_count,
            "triangles lie on another one, turned round or with other attributes; they stay and hinder simplification. \
             Use a double-sided material instead of a second sheet",
        ),
        (
            "non-manifold-edges",
            seams.non_manifold_edge_count,
            "edges have more than two triangles; they hinder simplification. Part the sheets that meet there",
        ),
        (
            "non-manifold-positions",
            seams.non_manifold_position_count,
            "places where surfaces meet in a point or on an edge of more than two triangles; they hinder simplification",
        ),
        (
            "hurried-collapses",
            seams.hurried_collapse_count,
            "collapses go to places with more than 1,024 triangles each; of those not always the least visible one was taken first, or it would take the square of their number. \
             Part the triangles that meet there",
        ),
    ];
    let found = kinds.into_iter().filter(|(_, count, _)| *count > 0);
    found
        .map(|(code, count, message)| Warning {
            code,
            place: "mesh".to_owned(),
            count: count.into(),
            message: format!("{count} {message}"),
        })
        .collect()
}

/// Squared sine of the widest angle of a triangle that counts as a line.
const LINE_SINE_SQUARED: f64 = 1.0e-14;

/// Says how many triangles have three corners in a line: no area, though no two corners at one place. They stay: their edges may hold the
/// surface together. Code `flat-triangles`.
pub(crate) fn warn_of_flat_triangles(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<Warning> {
    let is_flat = |t: &&[u32; 3]| {
        let [a, b, c] = t.map(|v| glam::Vec3::from(positions[v as usize]).as_dvec3());
        let edges = [b - a, c - b, a - c];
        let most = edges.iter().map(|e| e.length_squared()).fold(0.0, f64::max);
        let apart = edges.iter().all(|e| e.length_squared() > 0.0);
        apart && edges[0].cross(edges[1]).length_squared() <= LINE_SINE_SQUARED * most * most
    };
    let count = triangles.iter().filter(is_flat).count();
    (count > 0).then(|| Warning {
        code: "flat-triangles",
        place: "mesh".to_owned(),
        count: count as u64,
        message: format!("{count} triangles have their corners in a line; they stay, and nothing is seen of them"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_without_area_are_counted() {
        let positions = [[0.0; 3], [1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [1.0, 0.0, 0.0], [0.5, 1.0e-3, 0.0]];
        let count = |triangles: &[[u32; 3]]| warn_of_flat_triangles(&positions, triangles).map_or(0, |w| w.count);
        assert_eq!(count(&[[0, 1, 2], [0, 1, 3], [2, 1, 0]]), 2);
        assert_eq!(
            count(&[[0, 1, 1], [0, 3, 4]]),
            0,
            "degenerate ones are dropped and counted elsewhere, thin ones have area"
        );
    }

    #[test]
    fn each_count_has_its_warning_and_none_has_none() {
        assert!(warn_of_surface(&SeamReport::default()).is_empty());
        let seams = SeamReport {
            degenerate_triangle_count: 1,
            duplicate_triangle_count: 2,
            coincident_triangle_count: 3,
            non_manifold_edge_count: 4,
            non_manifold_position_count: 5,
            hurried_collapse_count: 6,
            ..SeamReport::default()
        };
        let counts: Vec<u64> = warn_of_surface(&seams).iter().map(|warning| warning.count).collect();
        assert_eq!(counts, [1, 2, 3, 4, 5, 6]);
    }
}
