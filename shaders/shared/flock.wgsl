// Cells of a flock's grid. Needs `flock`.

// Column and row of a place; the outermost cells reach to infinity.
fn cell_at(place: vec2f) -> vec2i {
    let at = max((place - flock.low) / flock.sight_m, vec2f(0.0));
    return vec2i(min(vec2u(at), vec2u(flock.columns, flock.rows) - 1u));
}
