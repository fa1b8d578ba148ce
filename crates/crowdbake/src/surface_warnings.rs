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
pub(crate) fn warn_of_surface(seams: &SeamReport) -> Vec<Warning> {
    let kinds: [(&'static str, u32, &str); 5] = [
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_count_has_its_warning_and_none_has_none() {
        assert!(warn_of_surface(&SeamReport::default()).is_empty());
        let seams = SeamReport {
            degenerate_triangle_count: 1,
            duplicate_triangle_count: 2,
            coincident_triangle_count: 3,
            non_manifold_edge_count: 4,
            non_manifold_position_count: 5,
            ..SeamReport::default()
        };
        let counts: Vec<u64> = warn_of_surface(&seams).iter().map(|warning| warning.count).collect();
        assert_eq!(counts, [1, 2, 3, 4, 5]);
    }
}
