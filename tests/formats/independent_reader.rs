//! A reader written from `docs/FORMAT.md` alone: the standard library, no records, no bincode, no crate of ours.
//!
//! It reads what a viewer needs and walks the rest of the manifest to its last byte. It trusts the file: what is not in order panics.

/// A pack as the page describes it.
pub struct Reader<'a> {
    file: &'a [u8],
    /// Name, bytes and element size of each section.
    sections: Vec<(String, &'a [u8], usize)>,
    /// 3 to 5.
    pub version: u32,
    /// The manifest.
    pub generator: String,
    /// Rows of a joint's matrix in the animation section: 3 or 4.
    pub rows: usize,
    /// Names and tracks.
    pub characters: Vec<NamedCharacter>,
}

/// What the manifest says about a character, as far as this reader keeps it.
pub struct NamedCharacter {
    /// Its name.
    pub name: String,
    /// Name and parent of each node.
    pub nodes: Vec<(String, Option<u32>)>,
    /// Name of each clip, and its tracks' node, property, interpolation and ranges.
    pub clips: Vec<(String, Vec<Track>)>,
    /// Slide, path, and the slide along it of each clip.
    pub feet: Vec<(f32, Vec<Vec<f32>>, f32)>,
    /// Joint, begin and end of all clips' contacts.
    pub contacts: Vec<(u32, f32, f32)>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Name, material, triangles, rigid.
    pub parts: Vec<(String, u32, u32, bool)>,
    /// Vertices, triangles, error.
    pub levels: Vec<(u32, u32, f32)>,
    /// The quantised levels' numbers: rms, max, bound, texels, degrees, pixels, share poked through.
    pub measured: Vec<[f32; 7]>,
    /// Name, kind of target, its numbers, reached.
    pub discrete: Vec<(String, u32, Vec<f32>, bool)>,
    /// Frames measured: for the mean, and those added for the maximum.
    pub frames: [Vec<u32>; 2],
    /// What keeps each vertex of the coarsest level.
    pub obstacles: Vec<u8>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// A level with an index table.
pub struct LevelTable {
    /// Corners, in the order drawn.
    pub triangles: Vec<[usize; 3]>,
    /// First vertex in `refit_vertices`, for those that have their own.
    pub own_vertices: Option<usize>,
    /// Metres.
    pub bound_m: f32,
}

/// What materials have beside their base colour, and the names of images, finish images and skins.
pub struct Finishes {
    /// One a material.
    pub materials: Vec<Finish>,
    /// Three lists.
    pub names: [Vec<String>; 3],
    /// One a character: node and matrix of the joints, places, curves clip by clip.
    pub rigs: Vec<Rig>,
    /// One a character: copyright and extras.
    pub credits: Vec<[String; 2]>,
}

/// Joints, places, curves.
pub type Rig = (Vec<(u32, Vec<f32>)>, Vec<u32>, Vec<Vec<Track>>);

/// Of one material.
pub struct Finish {
    /// Metalness, roughness, emission and its strength.
    pub numbers: [f32; 6],
    /// Index of refraction, specular, base colour; empty where there is none.
    pub optional_numbers: [Vec<f32>; 3],
    /// Metal and roughness, normal, occlusion, emission, specular, specular colour, base colour: image, sampler, weight.
    pub textures: [Option<(u32, u8, f32)>; 7],
    /// BLEND.
    pub blend: bool,
}

/// A source curve.
pub struct Track {
    /// Node.
    pub node: u32,
    /// 0 translation, 1 rotation, 2 scale.
    pub property: u8,
    /// 0 step, 1 linear, 2 cubic spline.
    pub interpolation: u8,
    /// Key times.
    pub times: Vec<f32>,
    /// Values.
    pub values: Vec<f32>,
}

impl<'a> Reader<'a> {
    /// Section 1: header, table, checksums, padding.
    pub fn new(file: &'a [u8]) -> Self {
        assert_eq!(&file[..8], b"CROWDPK\0");
        let version = u32_at(file, 8);
        let section_count = [18, 20, 23][version as usize - 3];
        assert_eq!(u32_at(file, 12), section_count, "section count");
        assert_eq!((u64_at(file, 16), u64_at(file, 24)), (file.len(), 64), "file length and table");
        let table_end = 64 + 40 * section_count as usize;
        assert_eq!(u32_at(file, 32), crc32(&file[64..table_end]));
        assert!(file[36..60].iter().all(|&b| b == 0));
        assert_eq!(u32_at(file, 60), crc32(&file[..60]));
        let mut sections = Vec::new();
        let mut end = table_end;
        for entry in file[64..table_end].chunks(40) {
            let name = String::from_utf8(entry[..16].iter().copied().take_while(|&b| b != 0).collect()).unwrap();
            let (start, length) = (u64_at(entry, 16), u64_at(entry, 24));
            let element_bytes = u32_at(entry, 32) as usize;
            assert!(start.is_multiple_of(64) && start - end < 64 && length.is_multiple_of(element_bytes), "{name}");
            assert!(file[end..start].iter().all(|&b| b == 0), "padding before {name}");
            let section = &file[start..start + length];
            assert_eq!(u32_at(entry, 36), crc32(section), "{name}");
            sections.push((name, section, element_bytes));
            end = start + length;
        }
        assert!(file.len().is_multiple_of(64) && file.len() - end < 64 && file[end..].iter().all(|&b| b == 0));
        let mut reader = Self { file, sections, version, generator: String::new(), rows: 0, characters: Vec::new() };
        reader.read_manifest();
        reader
    }

    /// Names of the sections in file order.
    pub fn section_names(&self) -> Vec<&str> {
        self.sections.iter().map(|(name, ..)| name.as_str()).collect()
    }

    /// Bytes of element `index` of a section.
    pub fn element(&self, name: &str, index: usize) -> &'a [u8] {
        let (_, section, bytes) =
            self.sections.iter().find(|(section, ..)| section == name).expect("the section is in the table");
        &section[index * bytes..(index + 1) * bytes]
    }

    /// Elements of a section.
    pub fn count(&self, name: &str) -> usize {
        self.sections
            .iter()
            .find(|(section, ..)| section == name)
            .map_or(0, |(_, section, bytes)| section.len() / bytes)
    }

    /// A word of a character record.
    pub fn character(&self, character: usize, byte: usize) -> usize {
        u32_at(self.element("characters", character), byte) as usize
    }

    /// Section 3: the triangles of the level for at most `k` vertices.
    pub fn reform(&self, character: usize, k: usize) -> Vec<[usize; 3]> {
        let [vertex_offset, vertex_count, triangle_offset, lod_offset] =
            [0, 4, 8, 16].map(|b| self.character(character, b));
        let level = self.element("lods", lod_offset + k.min(vertex_count));
        let (kept, triangle_count) = (u32_at(level, 0) as usize, u32_at(level, 4) as usize);
        let look_up = |mut v: usize| {
            while v >= kept {
                v = u32_at(self.element("collapse_map", vertex_offset + v), 0) as usize;
            }
            v
        };
        let corners = |t| [0, 4, 8].map(|b| u32_at(self.element("triangles", triangle_offset + t), b) as usize);
        (0..triangle_count).map(|t| corners(t).map(look_up)).collect()
    }

    /// Section 3: the index tables of a character, quantised levels first.
    pub fn level_tables(&self, character: usize) -> Vec<LevelTable> {
        let set = self.element("level_sets", character);
        let [first, quantized, discrete] = [0, 4, 8].map(|b| u32_at(set, b) as usize);
        (first..first + quantized + discrete).map(|level| self.level_table(level)).collect()
    }

    fn level_table(&self, level: usize) -> LevelTable {
        let record = self.element("levels", level);
        let [vertex_count, triangle_count, first, width, own] = [0, 4, 8, 12, 16].map(|b| u32_at(record, b) as usize);
        assert_eq!(width, if vertex_count <= 65_535 { 2 } else { 4 });
        let index = |i: usize| match width {
            2 => u16_at(self.element("indices_16", first + i), 0) as usize,
            _ => u32_at(self.element("indices_32", first + i), 0) as usize,
        };
        let triangles = (0..triangle_count).map(|t| [0, 1, 2].map(|corner| index(t * 3 + corner))).collect();
        let own_vertices = if own == 0xffff_ffff { None } else { Some(own) };
        LevelTable { triangles, own_vertices, bound_m: f32_at(record, 20) }
    }

    /// Bind-space position of a refitted vertex.
    pub fn refit_position(&self, vertex: usize) -> [f32; 3] {
        [0, 4, 8].map(|b| f32_at(self.element("refit_vertices", vertex), b))
    }

    /// Section 5: the first three rows of `world * inverse_bind`.
    pub fn matrix(&self, character: usize, clip: usize, frame: usize, joint: usize) -> [[f32; 4]; 3] {
        let joint_count = self.character(character, 28);
        let record = self.element("clips", self.character(character, 32) + clip);
        let first = u32_at(record, 0) as usize;
        let row = |section: &str, at: usize| [0, 4, 8, 12].map(|b| f32_at(self.element(section, at), b));
        match (self.rows, self.character(character, 96)) {
            (3, 0) => return [0, 1, 2].map(|r| row("animation", first + (frame * joint_count + joint) * 3 + r)),
            (3, 1) => {
                let begin = first + frame * (joint_count * 3).div_ceil(2);
                return [0, 1, 2].map(|r| {
                    let place = (joint * 3 + r) * 8;
                    let texel = self.element("animation", begin + place / 16);
                    [0, 2, 4, 6].map(|b| half(u16_at(texel, place % 16 + b)))
                });
            }
            (3, 2) => return quantized(self.element("animation", first + frame * joint_count + joint)),
            _ => {}
        }
        let first = first + (frame * joint_count + joint) * 4;
        let rows = [0, 1, 2].map(|r| row("animation", first + r));
        assert_eq!(row("animation", first + 3), [0.0, 0.0, 0.0, 1.0]);
        let bind = self.character(character, 92) + 4 * joint;
        rows.map(|world| {
            [0, 1, 2, 3].map(|column| (0..4).map(|i| world[i] * row("inverse_binds", bind + i)[column]).sum())
        })
    }

    /// Position of a vertex, skinned in a frame.
    pub fn skin(&self, character: usize, vertex: usize, clip: usize, frame: usize) -> [f32; 3] {
        let record = self.element("vertices", self.character(character, 0) + vertex);
        let p = [0, 4, 8].map(|b| f32_at(record, b));
        let mut out = [0.0; 3];
        for influence in 0..4 {
            let joint = u16_at(record, 32 + 2 * influence) as usize;
            let weight = f32::from(u16_at(record, 40 + 2 * influence)) / 65_535.0;
            for (sum, row) in out.iter_mut().zip(self.matrix(character, clip, frame, joint)) {
                *sum += weight * (row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]);
            }
        }
        out
    }

    /// Section 5: the unit normal of a vertex.
    pub fn normal(&self, character: usize, vertex: usize) -> [f32; 3] {
        let record = self.element("vertices", self.character(character, 0) + vertex);
        let [mut x, mut y] = [12, 14].map(|b| (f32::from(u16_at(record, b) as i16) / 32_767.0).max(-1.0));
        let z = 1.0 - x.abs() - y.abs();
        let t = (-z).max(0.0);
        x = if x >= 0.0 { x - t } else { x + t };
        y = if y >= 0.0 { y - t } else { y + t };
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    }

    /// The bytes of an image.
    pub fn image(&self, index: usize) -> &'a [u8] {
        let record = self.element("images", index);
        let (start, length) = (u64_at(record, 0), u64_at(record, 8));
        let first = self.element("image_bytes", start).as_ptr() as usize - self.file.as_ptr() as usize;
        assert_eq!(first % 64, 0, "images can be mapped");
        &self.file[first..first + length]
    }

    /// The bytes of an image of the finishes.
    pub fn finish_image(&self, index: usize) -> &'a [u8] {
        let record = self.element("finish_images", index);
        let (start, length) = (u64_at(record, 0), u64_at(record, 8));
        let first = self.element("finish_bytes", start).as_ptr() as usize - self.file.as_ptr() as usize;
        &self.file[first..first + length]
    }

    /// Section 4: the finishes.
    pub fn finishes(&self) -> Finishes {
        let bytes = &self.sections.iter().find(|(name, ..)| name == "finishes").expect("it is in the table").1;
        let mut at = Cursor { bytes, at: 0 };
        let materials = at.list(Cursor::finish);
        let names = [0; 3].map(|_| at.list(Cursor::string));
        let rigs = at.list(|at| {
            let joints = at.list(|at| (at.varint() as u32, at.floats(16)));
            let places = at.list(|at| at.varint() as u32);
            (joints, places, at.list(|at| at.list(|at| self.read_track(at))))
        });
        let credits = at.list(|at| [at.string(), at.string()]);
        assert_eq!(at.at, bytes.len(), "the finishes are used up");
        Finishes { materials, names, rigs, credits }
    }

    /// Texels that a character's impostors are wide and high.
    pub fn impostor_size(&self, character: usize) -> (u32, u32) {
        let record = self.element("impostors", character);
        let [tile, azimuths, elevations, poses, clips] = [0, 4, 8, 12, 16].map(|b| u32_at(record, b));
        (tile * azimuths, tile * elevations * poses * clips)
    }

    /// The bytes of their colours or normals.
    pub fn impostor_picture(&self, character: usize, is_normal: bool) -> &'a [u8] {
        let record = self.element("impostors", character);
        let (start, length) = match is_normal {
            false => (u64_at(record, 24), u32_at(record, 40) as usize),
            true => (u64_at(record, 32), u32_at(record, 44) as usize),
        };
        let first = self.element("impostor_bytes", start).as_ptr() as usize - self.file.as_ptr() as usize;
        assert_eq!(first % 64, 0, "pictures can be mapped");
        &self.file[first..first + length]
    }

    /// Section 4.
    fn read_manifest(&mut self) {
        let bytes = self.sections[0].1;
        let mut at = Cursor { bytes, at: 0 };
        self.generator = at.string();
        self.rows = [3, 4][at.varint() as usize];
        self.characters = (0..at.varint()).map(|_| self.read_character(&mut at)).collect();
        assert_eq!(at.at, bytes.len(), "the manifest is used up");
    }

    fn read_character(&self, at: &mut Cursor<'_>) -> NamedCharacter {
        let name = at.string();
        let _source = at.string();
        let nodes = at.list(|at| {
            let name = at.string();
            let parent = if at.byte() == 1 { Some(at.varint() as u32) } else { None };
            at.floats(3 + 4 + 3);
            (name, parent)
        });
        let _joints = at.list(|at| (at.varint(), at.floats(16)));
        let (mut contacts, mut feet) = (Vec::new(), Vec::new());
        let clips = at.list(|at| {
            let clip = (at.string(), at.list(|at| self.read_track(at)));
            contacts.extend(at.list(|at| {
                let (joint, times) = (at.varint() as u32, at.floats(2));
                (joint, times[0], times[1])
            }));
            feet.push((at.floats(1)[0], at.list(|at| at.floats(2)), at.floats(1)[0]));
            clip
        });
        let materials = at.list(Cursor::string);
        let parts = at.list(|at| (at.string(), at.varint() as u32, at.varint() as u32, at.byte() == 1));
        let _criteria = at.string();
        let _fps = at.floats(1);
        let _seams = [0; 12].map(|_| at.varint());
        let levels = at.list(|at| (at.varint() as u32, at.varint() as u32, at.floats(1)[0]));
        let measured = at.list(Cursor::measured);
        let discrete = at.list(|at| {
            let (name, kind) = (at.string(), at.varint() as u32);
            let target = at.floats(if kind == 3 { 2 } else { 1 });
            let reached = at.byte() == 1;
            at.measured();
            (name, kind, target, reached)
        });
        let _samples = at.varint();
        let frames = [0; 2].map(|_| at.list(|at| at.varint() as u32));
        let _blocked = [0; 5].map(|_| at.varint());
        let obstacles = at.list(Cursor::byte);
        let warnings = at.list(Cursor::string);
        NamedCharacter {
            name,
            nodes,
            clips,
            feet,
            contacts,
            materials,
            parts,
            levels,
            measured,
            discrete,
            frames,
            obstacles,
            warnings,
        }
    }

    fn read_track(&self, at: &mut Cursor<'_>) -> Track {
        let (node, property, interpolation) = (at.varint() as u32, at.byte(), at.byte());
        let mut range = || {
            let (offset, count) = (at.varint() as usize, at.varint() as usize);
            (offset..offset + count).map(|i| f32_at(self.element("track_values", i), 0)).collect()
        };
        Track { node, property, interpolation, times: range(), values: range() }
    }
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Cursor<'_> {
    fn byte(&mut self) -> u8 {
        self.at += 1;
        self.bytes[self.at - 1]
    }

    fn little_endian(&mut self, count: usize) -> u64 {
        (0..count).map(|i| u64::from(self.byte()) << (8 * i)).sum()
    }

    fn varint(&mut self) -> u64 {
        match self.byte() {
            251 => self.little_endian(2),
            252 => self.little_endian(4),
            253 => self.little_endian(8),
            small => u64::from(small),
        }
    }

    fn floats(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| f32::from_bits(self.little_endian(4) as u32)).collect()
    }

    fn measured(&mut self) -> [f32; 7] {
        let _counts = [self.varint(), self.varint()];
        let distances = self.floats(2);
        let _where = [self.varint(), self.varint()];
        let rest = self.floats(5);
        [distances[0], distances[1], rest[0], rest[1], rest[2], rest[3], rest[4]]
    }

    fn texture(&mut self) -> Option<(u32, u8, f32)> {
        (self.byte() == 1).then(|| (self.varint() as u32, self.byte(), self.floats(1)[0]))
    }

    fn optional(&mut self, count: usize) -> Vec<f32> {
        if self.byte() == 1 { self.floats(count) } else { Vec::new() }
    }

    fn finish(&mut self) -> Finish {
        let surface = self.floats(2);
        let [metal, normal, occlusion] = [0; 3].map(|_| self.texture());
        let light = self.floats(4);
        let emission = self.texture();
        let (ior, specular) = (self.optional(1), self.optional(4));
        let [specular_texture, specular_color] = [0; 2].map(|_| self.texture());
        let blend = self.byte() == 1;
        let (color, base) = if self.byte() == 1 { (self.floats(4), self.texture()) } else { (Vec::new(), None) };
        Finish {
            numbers: [surface[0], surface[1], light[0], light[1], light[2], light[3]],
            optional_numbers: [ior, specular, color],
            textures: [metal, normal, occlusion, emission, specular_texture, specular_color, base],
            blend,
        }
    }

    fn string(&mut self) -> String {
        let length = self.varint();
        String::from_utf8((0..length).map(|_| self.byte()).collect()).expect("names are UTF-8")
    }

    fn list<T>(&mut self, mut read: impl FnMut(&mut Self) -> T) -> Vec<T> {
        (0..self.varint()).map(|_| read(self)).collect()
    }
}

/// Of an exponent of normal floats.
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

/// Section 5: a half float.
fn half(bits: u16) -> f32 {
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size =
        if exponent == 0 { mantissa / 16_777_216.0 } else { (1.0 + mantissa / 1024.0) * power_of_two(exponent - 15) };
    if bits >> 15 == 1 { -size } else { size }
}

/// Section 5: rows of a quantised joint.
fn quantized(texel: &[u8]) -> [[f32; 4]; 3] {
    let step = |exponent: u8| if exponent == 0 { 0.0 } else { power_of_two(i32::from(exponent) - 127) };
    let number = |at: usize| f32::from(u16_at(texel, at) as i16);
    let [x, y, z, w] = [0, 2, 4, 6].map(|at| number(at) * step(texel[14]));
    let [tx, ty, tz] = [8, 10, 12].map(|at| number(at) * step(texel[15]));
    [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - z * w), 2.0 * (x * z + y * w), tx],
        [2.0 * (x * y + z * w), w * w + y * y - x * x - z * z, 2.0 * (y * z - x * w), ty],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), w * w + z * z - x * x - y * y, tz],
    ]
}

/// CRC-32 bit by bit, as section "Conventions" gives it.
pub fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), |crc, _| step(crc)))
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

/// A little-endian word.
pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from(u16_at(bytes, at)) | (u32::from(u16_at(bytes, at + 2)) << 16)
}

/// A little-endian double word.
pub fn u64_at(bytes: &[u8], at: usize) -> usize {
    u32_at(bytes, at) as usize | ((u32_at(bytes, at + 4) as usize) << 32)
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(u32_at(bytes, at))
}
