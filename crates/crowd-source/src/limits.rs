//! What a file may ask for. Each limit says what it buys.

/// Largest coordinate of a vertex at rest, metres. Floats are 6 cm apart there: beyond it is no character, and products of
/// positions stay far within the numbers' range.
pub(crate) const POSITION_M: f32 = 1e6;

/// Largest texture coordinate, textures from the origin. Floats are a sixteenth of a texture apart there: beyond it nothing is shown as it was meant.
pub(crate) const UV: f32 = 1e6;

/// Upper bounds on what the reader allocates for one character.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of the asset; of all files that it names together; of all that decoding data URIs and compressed buffers
    /// makes. Bounds reading.
    pub file_bytes: u64,
    /// Vertices of a character before equal ones are merged. Keeps 32-bit offsets safe in the pack.
    pub vertices: u64,
    /// Triangles of a character.
    pub triangles: u64,
    /// Nodes of the file.
    pub nodes: u64,
    /// Joints of a skin, and matrices that the vertices of a character follow. Vertices address them with 16 bits.
    pub joints: u64,
    /// Key frames over all tracks.
    pub keys: u64,
    /// Pixels of one image. Bounds decoding.
    pub image_pixels: u64,
    /// Pixels of the longer side of an image. What packs hold and GPUs take.
    pub image_side: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 1 << 30,
            vertices: 4_000_000,
            triangles: 4_000_000,
            nodes: 65_536,
            joints: 4_096,
            keys: 16_000_000,
            image_pixels: 8_192 * 8_192,
            image_side: 16_384,
        }
    }
}
