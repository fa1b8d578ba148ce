//! What a pack may hold. Each limit says what it buys.

/// Bytes of a pack: offsets in elements stay below 2^32.
pub const PACK_BYTES: u64 = 8 << 30;
/// Characters: instances address them with 16 bits where space counts.
pub const CHARACTERS: u64 = 4_096;
/// Vertices of one character: 22 bits leave ten for instances in debug views.
pub const VERTICES_PER_CHARACTER: u64 = 1 << 22;
/// Triangles of one character: twice the vertices, as closed meshes have, and as much again for open ones.
pub const TRIANGLES_PER_CHARACTER: u64 = 1 << 24;
/// Clips of one character: more is a motion library, which wants its own file.
pub const CLIPS_PER_CHARACTER: u64 = 65_536;
/// Materials of one character: vertices address them with 16 bits.
pub const MATERIALS_PER_CHARACTER: u64 = 65_535;
/// Images: keeps the texture table of a pack within what a GPU can list.
pub const IMAGES: u64 = 65_536;
/// Pixels along one side of an image: the largest texture of desktop GPUs.
pub const IMAGE_SIDE_PX: u32 = 32_768;
/// Joints of one character: vertices address them with 16 bits.
pub const JOINTS_PER_CHARACTER: u64 = 4_096;
/// Quantised levels of one character: steps of 6 % between full detail and a fiftieth; a draw each is cheap.
pub const QUANTIZED_LEVELS: u64 = 64;
/// Discrete levels of one character: engines stop at eight.
pub const DISCRETE_LEVELS: u64 = 32;
/// Bytes of the decoded manifest: bounds what bincode may allocate.
pub const MANIFEST_BYTES: usize = 256 << 20;
/// Texels along one side of an impostor's tile: larger ones are no stand-ins for the small.
pub const IMPOSTOR_TILE_PX: u32 = 128;
/// Directions around a character, and poses of a clip, that have impostors.
pub const IMPOSTOR_DIRECTIONS: u32 = 64;
/// Texels of all impostors of a pack: 256 MiB of colours and as much of normals once decoded.
pub const IMPOSTOR_TEXELS: u64 = 1 << 26;
