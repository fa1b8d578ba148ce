// Levels of dots without a table.

// How many dots somebody is at that product of weight and height, below DOT_REACH. What they are: DOT_COUNTS in
// crowd-stages/src/dots.rs.
fn dots_at(product: vec4f) -> vec4u {
    let unit = f32(DOT_VERTICES);
    let none = vec4u();
    return vec4u(1u)
        + select(none, vec4u(1u), product >= vec4f(2.0 * unit))
        + select(none, vec4u(2u), product >= vec4f(4.0 * unit))
        + select(none, vec4u(4u), product >= vec4f(8.0 * unit))
        + select(none, vec4u(8u), product >= vec4f(16.0 * unit));
}
