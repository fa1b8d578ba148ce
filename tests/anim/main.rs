//! Characters in motion: poses at the right times, bounds that hold every vertex, and every point of a level; eyes that stay or go together.

mod fades;
mod feet;
mod level_bounds;
mod real_clips;
mod twin_parts;
