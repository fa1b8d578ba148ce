//! Where people may walk: polygons with holes, read from well-known text, and the surfaces to draw them by.

mod surface;
mod wkt;

use glam::DVec2;

pub use surface::Surface;

/// A polygon: an outer ring and holes. Rings are not closed by repeating their first point; the walkable side is on the left
/// of every edge, so outer rings go counterclockwise and holes clockwise in the file's plane (x right, y up).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Polygon {
    /// The outer ring first.
    pub(crate) rings: Vec<Vec<DVec2>>,
}

/// Where people may walk.
///
/// In the file's plane: x right, y up; in the scene x stays and y becomes -Z.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkableArea {
    pub(crate) polygons: Vec<Polygon>,
}

impl WalkableArea {
    /// Reads `POLYGON`, `MULTIPOLYGON` or a `GEOMETRYCOLLECTION` of those.
    ///
    /// # Errors
    /// [`crate::Error::Content`] with the place in the text: another geometry, a ring of fewer than three points, a number
    /// that is none or beyond 1e9, more than 20,000 points.
    pub fn parse(text: &str) -> crate::Result<Self> {
        wkt::parse(text)
    }

    /// Polygons, holes not counted.
    pub fn polygon_count(&self) -> usize {
        self.polygons.len()
    }

    /// Square metres.
    pub fn square_metres(&self) -> f64 {
        self.polygons.iter().flat_map(|polygon| &polygon.rings).map(|ring| signed_area(ring)).sum()
    }

    /// Least and greatest corner, in the file's plane.
    pub(crate) fn extent(&self) -> (DVec2, DVec2) {
        let points = || self.polygons.iter().flat_map(|polygon| &polygon.rings).flatten();
        points().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// The same area, seen from `origin`.
    pub(crate) fn moved_to(mut self, origin: [f64; 2]) -> Self {
        let points = self.polygons.iter_mut().flat_map(|polygon| &mut polygon.rings).flatten();
        points.for_each(|point| *point -= DVec2::from_array(origin));
        self
    }
}

/// Counterclockwise positive.
pub(crate) fn signed_area(ring: &[DVec2]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    // From the first point, so that map coordinates do not cancel.
    let from = ring.first().copied().unwrap_or_default();
    0.5 * ring.iter().zip(next).map(|(a, b)| (*a - from).perp_dot(*b - from)).sum::<f64>()
}
