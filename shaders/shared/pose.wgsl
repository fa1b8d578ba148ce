// A time of a clip: two frames, and the share of the later one.
struct Pose {
    first_texel: u32,
    second_texel: u32,
    blend: f32,
}

// Of the clip that an instance plays.
fn played_pose(drawn: DrawnInstance) -> Pose {
    return Pose(drawn.first_texel, drawn.second_texel, drawn.blend);
}

// Of the clip that it leaves.
fn left_pose(drawn: DrawnInstance) -> Pose {
    return Pose(drawn.leaving_first_texel, drawn.leaving_second_texel, drawn.leaving_blend);
}
