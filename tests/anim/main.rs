//! Real characters in motion: poses at the right times, bounds that hold every vertex.

mod real_clips;
