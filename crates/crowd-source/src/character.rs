//! The editable, validated form of a character between the file formats and the bake.

use crate::RawFinish;

/// One character as found in a file: one mesh in one bind space, its node tree, joints, clips, materials and images.
#[derive(Debug, Clone, PartialEq)]
pub struct RawCharacter {
    /// The file's stem.
    pub name: String,
    /// Name of its first skin; empty where that has none.
    pub skin_name: String,
    /// What the file says of its makers.
    pub credits: RawCredits,
    /// All triangles of the character.
    pub mesh: RawMesh,
    /// At least one; `RawPart::material` points here.
    pub materials: Vec<RawMaterial>,
    /// Images of the base colours, still encoded as found.
    pub images: Vec<RawImage>,
    /// Images of what the materials have beside ([`RawFinish`]): carried to exports, not shown.
    pub finish_images: Vec<RawImage>,
    /// The node tree, parents before children. At least one node.
    pub nodes: Vec<RawNode>,
    /// The matrices that vertices refer to. At least one.
    pub joints: Vec<RawJoint>,
    /// The joints of its skin as the file lists them, used or not, for exports.
    pub rig: RawRig,
    /// The animations; empty when the file has none.
    pub clips: Vec<RawClip>,
    /// What was dropped, repaired or approximated, with counts and remedies.
    pub warnings: Vec<Warning>,
}

/// What a file says of its makers and its licence, for exports: licences ask for it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RawCredits {
    /// glTF's `asset.copyright`; empty where there is none. At most 64 KiB.
    pub copyright: String,
    /// glTF's `asset.extras`, the text of a JSON object (author, licence, source...); empty where there is none. At most 64 KiB.
    pub extras: String,
}

/// Vertices (one universal index for all attributes) and triangles of a character.
///
/// All per-vertex arrays have one entry per vertex. Positions are in the character's common bind space, in metres, Y up,
/// facing +Z (glTF's convention).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMesh {
    /// Bind-space positions, metres, finite.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals in bind space. Where the file has none: area-weighted ones, and the material says `flat_normals`.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates after `KHR_texture_transform`, v down as in glTF; zero where the file has none.
    pub uvs: Vec<[f32; 2]>,
    /// Linear vertex colours, RGBA8; white where the file has none.
    pub colors: Vec<[u8; 4]>,
    /// Indices into [`RawCharacter::joints`], strongest first; unused ones are 0 with weight 0.
    pub joints: Vec<[u16; 4]>,
    /// Weights, non-negative, summing to 1.
    pub weights: Vec<[f32; 4]>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Consecutive runs of triangles; together they cover all triangles.
    pub parts: Vec<RawPart>,
}

/// A run of triangles with one material: a primitive of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct RawPart {
    /// Mesh or node name, for messages and reports.
    pub name: String,
    /// Index into [`RawCharacter::materials`].
    pub material: u32,
    /// First triangle of the run.
    pub first_triangle: u32,
    /// Number of triangles.
    pub triangle_count: u32,
    /// True for an unskinned mesh that hangs from a node (a hat, a weapon): every vertex follows one joint.
    pub rigid: bool,
}

/// A node of the tree, with its transform at rest (local to the parent).
#[derive(Debug, Clone, PartialEq)]
pub struct RawNode {
    /// Name in the file, or `node N`.
    pub name: String,
    /// Index of the parent, always smaller than this node's own.
    pub parent: Option<u32>,
    /// Metres.
    pub translation: [f32; 3],
    /// Unit quaternion, x y z w.
    pub rotation: [f32; 4],
    /// Factors; may be negative, non-uniform.
    pub scale: [f32; 3],
}

/// A matrix that vertices can follow: `world(node) * inverse_bind` takes bind space to the posed character.
///
/// Skins of one file may each have their own bind space; the reader moves them all into one common space (vertices by an
/// affine map S, inverse bind matrices by its inverse, which changes no pose), so that parts that touch in the pose at
/// rest touch in bind space too.
#[derive(Debug, Clone, PartialEq)]
pub struct RawJoint {
    /// Index into [`RawCharacter::nodes`].
    pub node: u32,
    /// Column-major 4x4, as in glTF.
    pub inverse_bind: [f32; 16],
}

/// A skin's list of joints. Empty where it is [`RawCharacter::joints`], or the file has no skin.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawRig {
    /// The first skin's joints in the file's order, then those of `joints` that it lacks.
    pub joints: Vec<RawJoint>,
    /// For each of `joints`, where it stands in this list.
    pub places: Vec<u32>,
}

/// An animation clip: tracks over one time axis.
#[derive(Debug, Clone, PartialEq)]
pub struct RawClip {
    /// Name in the file, or `clip N`; unique within the character.
    pub name: String,
    /// The curves; never two for one node and property.
    pub tracks: Vec<RawTrack>,
    /// Curves of other nodes, which move nothing of the mesh; for exports.
    pub spare_tracks: Vec<RawTrack>,
}

/// One curve: a property of a node over time.
#[derive(Debug, Clone, PartialEq)]
pub struct RawTrack {
    /// Index into [`RawCharacter::nodes`].
    pub node: u32,
    /// What it moves.
    pub property: RawProperty,
    /// How to go from key to key.
    pub interpolation: RawInterpolation,
    /// Key times in seconds, finite, strictly increasing, at least one.
    pub times: Vec<f32>,
    /// 3 (translation, scale) or 4 (rotation) floats a key; for cubic splines in-tangent, value, out-tangent a key.
    pub values: Vec<f32>,
}

/// The property that a track moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RawProperty {
    /// Metres, 3 floats.
    Translation,
    /// Unit quaternion, 4 floats.
    Rotation,
    /// Factors, 3 floats.
    Scale,
}

/// How a track goes from key to key (glTF 2.0, appendix C).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RawInterpolation {
    /// Holds the key's value.
    Step,
    /// Linear, spherical for rotations.
    Linear,
    /// Hermite spline with tangents scaled by the key distance.
    CubicSpline,
}

/// Surface of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct RawMaterial {
    /// Name in the file, or `material N`.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Base colour texture.
    pub texture: Option<RawTexture>,
    /// Pixels with less alpha than this are not drawn; `None` for opaque. BLEND becomes half the
    /// factor's alpha, at most 0.5, with a warning: a pane of alpha 0.3 stays, and the texture's own alpha cuts it at half.
    pub alpha_cutoff: Option<f32>,
    /// Back faces are drawn too.
    pub double_sided: bool,
    /// `KHR_materials_unlit`.
    pub unlit: bool,
    /// The file gives no normals: glTF asks for flat shading, one normal a triangle. In OBJ: `s off` and no normals.
    pub flat_normals: bool,
    /// What it has beside its base colour.
    pub finish: RawFinish,
}

/// The cutoff of a mask that stands for blending with a factor of that alpha: half of it, so that the texture's alpha is cut
/// at a half, whatever the factor. 0.5 for a factor of 0, which nothing is to be seen of.
pub(crate) fn blend_cutoff(alpha: f32) -> f32 {
    if alpha > 0.0 { 0.5 * alpha.min(1.0) } else { 0.5 }
}

/// A material's texture: image, wrapping and filters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawTexture {
    /// Index into [`RawCharacter::images`].
    pub image: u32,
    /// Along u.
    pub wrap_u: RawWrap,
    /// Along v.
    pub wrap_v: RawWrap,
    /// How texels are blended.
    pub filters: RawFilters,
}

/// How texels are blended; what a file leaves open is linear. Exports hand it on; our own pictures blend linearly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RawFilters {
    /// Enlarged texels are squares.
    pub mag_nearest: bool,
    /// Where texels are smaller than pixels.
    pub min: RawMinFilter,
}

/// glTF's filters for texels smaller than pixels: within a size of the image, then between two sizes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RawMinFilter {
    /// Blended within and between sizes.
    #[default]
    LinearMipmapLinear,
    /// Neither.
    NearestMipmapNearest,
    /// Within one size.
    LinearMipmapNearest,
    /// Between two sizes.
    NearestMipmapLinear,
    /// Not blended, of the full size alone.
    Nearest,
    /// Blended, of the full size alone.
    Linear,
}

/// Texture wrapping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RawWrap {
    /// Tile.
    Repeat,
    /// Hold the border.
    Clamp,
    /// Tile, every other one mirrored.
    Mirror,
}

/// An image, still encoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawImage {
    /// Name or file name.
    pub name: String,
    /// The file gave that name; else it is a number, for messages.
    pub named: bool,
    /// PNG, JPEG or WebP.
    pub encoding: ImageEncoding,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// The file's bytes, checked to decode at least as far as the header.
    pub bytes: Vec<u8>,
}

/// Encodings the reader lets through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ImageEncoding {
    /// Portable Network Graphics.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP (EXT_texture_webp).
    WebP,
}

/// Something was dropped, repaired or approximated.
///
/// | code | what it means |
/// |---|---|
/// | `alpha-blend-as-mask` | transparency is drawn as a mask, cut where the texture's alpha is below a half |
/// | `attributes-ignored` | vertex attributes that nothing here reads: exports will not have them |
/// | `bind-space-kept` | a skin's heaviest joint has no size at rest; its bind space was not moved |
/// | `black-factor-ignored` | MTL: a black `Kd` over a texture became white |
/// | `clip-renamed` | a clip had the name of another, none, or one that would steer a terminal |
/// | `clip-without-tracks` | an animation moves no joint and was left out |
/// | `credits-left-out` | a copyright or extras of the asset too long to keep; exports will not have them |
/// | `degenerate-triangles-dropped` | triangles that use one vertex twice |
/// | `double-curves-ignored` | a second curve for one node and property |
/// | `empty-primitive` | a primitive without triangles |
/// | `extension-ignored` | an optional extension that would change the picture |
/// | `filter-unknown` | taken as LINEAR, or LINEAR_MIPMAP_LINEAR |
/// | `incomplete-triangles` | indices left over after the last whole triangle |
/// | `material-reduced` | a texture or an extension of a material that exports will not have |
/// | `material-library-missing`, `material-lines-ignored` | MTL: not there, or in part not whole |
/// | `morph-targets-ignored`, `morph-curves-ignored` | shapes and their curves |
/// | `normals-missing`, `normals-repaired` | computed from the triangles |
/// | `points-and-lines-skipped` | no surface |
/// | `rotation-repaired`, `rotation-keys-repaired` | quaternions of length zero |
/// | `several-skeletons` | skins that share no joint: more than one character in a file, as a rule |
/// | `shear-dropped` | a node's matrix is no translation, rotation and scale |
/// | `texture-options-ignored` | MTL: options before a texture's name |
/// | `unknown-curves-ignored` | curves of something else than translation, rotation, scale |
/// | `turned-surfaces` | closed off parts whose triangles face away from their normals |
/// | `uvs-missing`, `uvs-repaired` | zeros in their place |
/// | `weights-dropped`, `weights-missing`, `weights-negative` | four strongest kept; first joint taken; taken as zero |
/// | `weights-normalized` | weights that did not sum to 1, to a hundredth, were scaled |
/// | `wrap-mode-unknown` | taken as REPEAT |
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// Stable name, kebab-case, out of the table above.
    pub code: &'static str,
    /// Where: mesh, primitive, node or material.
    pub place: String,
    /// How many things it happened to.
    pub count: u64,
    /// A sentence for people: what was found, what was done, what they can do.
    pub message: String,
}
