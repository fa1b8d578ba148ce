//! Numbers the shaders and the dispatches agree on; `shaders/shared/records.wgsl` has the same.

/// Workgroups beyond 65,535 are folded into rows of this many.
pub const FOLD_COLUMNS: u32 = 32_768;
/// Threads of a group that works on one element each.
pub const BLOCK_SIZE: u32 = 256;
/// Threads of a group that works on one instance.
pub const INSTANCE_GROUP_SIZE: u32 = 64;
/// Threads of a sorting group, also the most values of a digit.
pub const SORT_BLOCK_SIZE: u32 = 64;
/// Instances of each thread of a sorting group, one after another.
pub const SORT_RUN: u32 = 32;
/// Most keys that are sorted in one pass, those in no bucket included.
pub const AT_ONCE_KEYS: u32 = 1024;
/// Most runs of instances there, a thread each.
pub const AT_ONCE_RUNS: u32 = 256;
/// Instances of the shortest run.
pub const AT_ONCE_SHORTEST: u32 = 256;
/// Threads of a group there: as many as the lanes that a processor works on at a time.
pub const AT_ONCE_GROUP_SIZE: u32 = 8;
/// Heights that [`crate::cpu::fill_budget`] tries in one pass.
pub const FILL_CANDIDATES: u32 = 16;
/// Heights that its shader tries in a round.
pub const FILL_TRIED: u32 = 8;
/// Most chunks of instances that it sums.
pub const FILL_CHUNKS: u32 = 1024;
/// Entries of a character's error table: 32 for each doubling of the pixels that a metre takes.
pub const ERROR_ENTRIES: u32 = 1024;
/// Float bits of the first: 2^-16 a metre.
pub const ERROR_FIRST_BITS: u32 = (127 - 16) << 23;
/// Float bits of an entry.
pub const ERROR_SHIFT: u32 = 18;
/// Most shadow maps of the sun.
pub const MAX_CASCADES: u32 = 4;
/// Levels of the largest depth pyramid.
pub const PYRAMID_LEVELS: u32 = 16;
/// At most this part of the budget is kept for who comes into sight.
pub const RESERVE_PART: u32 = 128;
/// Levels of dots below a character's coarsest mesh: of one, two, four, ... dots.
pub const DOT_LEVELS: u32 = 5;
/// Vertices of a dot.
pub const DOT_VERTICES: u32 = 3;
/// Vertices of an impostor.
pub const IMPOSTOR_VERTICES: u32 = 4;
/// Triangles of an impostor.
pub const IMPOSTOR_TRIANGLES: u32 = 2;
/// Densities of points in a far character's place.
pub const POINT_LEVELS: u32 = 4;
/// Most bits of a digit of the sort.
pub const MAX_DIGIT_BITS: u32 = 6;
