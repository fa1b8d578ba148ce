//! What a pack may hold. Each limit says what it buys.

/// Bytes of a pack: offsets in elements stay below 2^32.
pub const PACK_BYTES: u64 = 8 << 30;
/// Characters: instances address them with 16 bits where space counts.
pub const CHARACTERS: u64 = 4_096;
/// Vertices of one character: 22 bits leave ten for instances in debug views.
pub const VERTICES_PER_CHARACTER: u64 = 1 << 22;
/// Joints of one character: vertices address them with 16 bits.
pub const JOINTS_PER_CHARACTER: u64 = 4_096;
/// Bytes of the decoded manifest: bounds what bincode may allocate.
pub const MANIFEST_BYTES: usize = 256 << 20;
