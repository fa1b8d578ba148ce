//! Paints a person: face, hair, cloth. Colours are asked for by place on the body, so that lines run across seams.

use glam::{Vec3, vec3};

use crate::atlas::Spot;
use crate::body::{Figure, part};
use crate::profile::{Profile, bell, mix, smoothstep};

/// Region ids of the region maps; fixtures/README.md lists them.
#[allow(missing_docs, reason = "fixtures/README.md lists them")]
pub mod region {
    pub const SKIN: u8 = 1;
    pub const HAIR: u8 = 2;
    pub const EYES: u8 = 3;
    pub const LIPS: u8 = 4;
    pub const TOP: u8 = 5;
    pub const LEGWEAR: u8 = 6;
    pub const SHOES: u8 = 7;
    pub const TRIM: u8 = 8;
    pub const COAT: u8 = 9;
    pub const MARKS: u8 = 10;
    pub const HORN: u8 = 11;
}

/// An sRGB colour from its hex code.
pub const fn rgb(hex: u32) -> Vec3 {
    vec3(((hex >> 16) & 255) as f32 / 255.0, ((hex >> 8) & 255) as f32 / 255.0, (hex & 255) as f32 / 255.0)
}

/// A woven or printed cloth. Lengths in metres; `turns` are repeats once around the trunk.
#[derive(Clone, Debug)]
pub enum Cloth {
    /// One colour.
    Plain(Vec3),
    /// Rings of the second colour: distance and share.
    Stripes(Vec3, Vec3, f32, f32),
    /// Ground, broad bands, thin lines; distance; turns.
    Plaid(Vec3, Vec3, Vec3, f32, f32),
    /// Chequered.
    Checks(Vec3, Vec3, f32, f32),
    /// Lengthwise pin stripes: ground, line, turns.
    Pin(Vec3, Vec3, f32),
    /// Blue jeans: ground, and faded over the thighs and knees.
    Denim(Vec3, Vec3),
    /// Plain with decorated bands: ground, band, ornament, distance, turns.
    Bands(Vec3, Vec3, Vec3, f32, f32),
}

impl Cloth {
    /// The colour at `along` metres and `around` turns; `round` scales the repeats on thinner parts.
    fn at(&self, along: f32, around: f32, round: f32) -> Vec3 {
        let part = |x: f32| x - libm::floorf(x);
        // Whole repeats only: the pattern must meet itself.
        let repeats = |n: f32| libm::roundf(n * round).max(2.0);
        match *self {
            Cloth::Plain(c) => c * mix(0.985, 1.015, part(libm::sinf(along * 913.0) * 43.7)),
            Cloth::Stripes(a, b, gap, share) => {
                if part(along / gap) < share {
                    b
                } else {
                    a
                }
            }
            Cloth::Plaid(ground, band, line, gap, turns) => {
                let (u, v) = (part(around * repeats(turns)), part(along / gap));
                let mut c = ground;
                let broad = |x: f32| x > 0.10 && x < 0.46;
                if broad(u) {
                    c = c.lerp(band, 0.5);
                }
                if broad(v) {
                    c = c.lerp(band, 0.5);
                }
                let thin = |x: f32| (x > 0.68 && x < 0.76) || (x > 0.255 && x < 0.295);
                if thin(u) || thin(v) { c.lerp(line, 0.8) } else { c }
            }
            Cloth::Checks(a, b, gap, turns) => {
                let (u, v) = (part(around * repeats(turns)) < 0.5, part(along / gap) < 0.5);
                match (u, v) {
                    (true, true) => b,
                    (false, false) => a,
                    _ => a.lerp(b, 0.5),
                }
            }
            Cloth::Pin(a, b, turns) => {
                if part(around * repeats(turns)) < 0.12 {
                    b
                } else {
                    a
                }
            }
            Cloth::Denim(a, b) => {
                let fade =
                    bell(around_front(around), 0.13) * (bell(along - 0.25, 0.16) + 0.7 * bell(along - 0.5, 0.07));
                let thread = 0.03 * libm::sinf(along * 700.0 + around * 260.0);
                a.lerp(b, fade.min(1.0)) + Vec3::splat(thread)
            }
            Cloth::Bands(ground, band, ornament, gap, turns) => {
                let v = part(along / gap);
                if v > 0.56 {
                    return ground;
                }
                let u = part(around * repeats(turns));
                let zig = (u - 0.5).abs() * 2.0;
                let w = (v - 0.28) / 0.28;
                let line = w.abs() > 0.86 || (w - (zig * 1.3 - 0.65)).abs() < 0.26;
                if line { ornament } else { band }
            }
        }
    }

    /// The first colour.
    fn ground(&self) -> Vec3 {
        match *self {
            Cloth::Plain(a)
            | Cloth::Stripes(a, ..)
            | Cloth::Plaid(a, ..)
            | Cloth::Checks(a, ..)
            | Cloth::Pin(a, ..)
            | Cloth::Denim(a, _)
            | Cloth::Bands(a, ..) => a,
        }
    }
}

/// Turns away from the front of a leg or trunk, 0..0.5.
fn around_front(around: f32) -> f32 {
    let x = around - libm::floorf(around);
    x.min(1.0 - x)
}

/// What closes the shirt in front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Front {
    /// Nothing: pulled over the head.
    Plain,
    /// A button border of this colour.
    Buttons(Vec3),
    /// Dungarees: bib and straps of the trousers' cloth.
    Bib,
    /// Braces over the shoulders.
    Braces(Vec3),
    /// A waistcoat of this colour, open at the neck, over the shirt, with a tie.
    Waistcoat(Vec3, Vec3),
}

/// Colours and cloths of one person.
#[derive(Clone, Debug)]
pub struct Look {
    /// Skin.
    pub skin: Vec3,
    /// Hair, and the brows.
    pub hair: Vec3,
    /// Iris.
    pub iris: Vec3,
    /// Lips.
    pub lips: Vec3,
    /// Strength of blush, of lashes, and size of the eyes.
    pub blush: f32,
    /// See `blush`.
    pub lashes: f32,
    /// See `blush`.
    pub eyes: f32,
    /// Brow thickness.
    pub brows: f32,
    /// Painted hairline by degrees from the front (`hy`).
    pub hairline: Vec<(f32, f32)>,
    /// Beard: strength of its colour, 0 none.
    pub beard: f32,
    /// Lines of age.
    pub age: f32,
    /// Freckles.
    pub freckles: bool,
    /// Shirt or blouse.
    pub top: Cloth,
    /// Trousers (and the skirt).
    pub legs: Cloth,
    /// Shoes and their soles.
    pub shoes: Vec3,
    /// See `shoes`.
    pub soles: Vec3,
    /// Belt.
    pub belt: Option<Vec3>,
    /// Front closing.
    pub front: Front,
    /// Shirt collar.
    pub collar: Option<Vec3>,
    /// Share of the arm where sleeves end, of the leg where trousers end and shoes begin.
    pub sleeve: f32,
    /// See `sleeve`.
    pub trouser: f32,
    /// See `sleeve`.
    pub shoe: f32,
    /// Trunk share where the top begins.
    pub hem: f32,
    /// A band in the hair.
    pub hair_band: Option<Vec3>,
}

/// The colour and region of one spot.
pub fn paint(f: &Figure, look: &Look, s: &Spot) -> (Vec3, u8) {
    let (colour, region) = match s.part {
        part::HEAD => head(f, look, s),
        part::EAR => (ear(look, s), region::SKIN),
        part::HAIR | part::TAIL => hair(f, look, s),
        part::TRUNK => trunk(f, look, s),
        part::ARM => arm(f, look, s),
        part::HAND => (hand(look, s), region::SKIN),
        part::LEG => leg(f, look, s),
        part::SKIRT if s.position.y > f.trunk_y(0.37) - 0.035 => (rgb(0x7a2330), region::TRIM),
        part::SKIRT => (look.legs.at(s.position.y, s.around, 1.0), region::LEGWEAR),
        part::FOOT => shoe(f, look, s),
        _ => (look.skin, region::SKIN),
    };
    // A breath of sky from above: forms stay readable when the light is flat.
    let shade = mix(0.86, 1.03, 0.5 + 0.5 * s.normal.y);
    (colour * shade, region)
}

fn darker(c: Vec3, k: f32) -> Vec3 {
    c * vec3(k, k * mix(1.0, k, 0.35), k * mix(1.0, k, 0.25))
}

fn head(f: &Figure, look: &Look, s: &Spot) -> (Vec3, u8) {
    let h = f.head_m();
    let (x, hy) = (s.position.x / h, (s.position.y - f.chin_y()) / h);
    let z = (s.position.z - f.m_z(0.0)) / h;
    let ax = x.abs();
    let degrees = libm::atan2f(x, z).abs() * 57.29578;
    if let Some(c) = look.collar
        && s.position.y < f.trunk_y(1.0) + 0.024 * f.build.height / 1.7 - 0.012 * z
    {
        let edge = (s.position.y - f.trunk_y(1.0)) > 0.018;
        return (if edge { darker(c, 0.85) } else { c }, region::TOP);
    }
    let hairline = Profile::new(&look.hairline);
    if hy > hairline.at(degrees) {
        return (darker(look.hair, 0.82), region::HAIR);
    }
    let mut c = look.skin;
    // Throat in the shade of the chin, sockets, beside the nose, below the lip.
    c = c.lerp(darker(look.skin, 0.72), 0.75 * smoothstep(0.03, -0.06, hy) * smoothstep(-0.25, 0.15, z));
    if look.beard > 0.0 {
        c = c.lerp(beard(look, ax, hy, degrees, s.around), look.beard * beard_share(ax, hy, degrees));
    }
    if z < 0.0 {
        return (c, region::SKIN);
    }
    let warm = vec3(0.86, 0.36, 0.30);
    c = c.lerp(warm.lerp(look.skin, 0.35), 0.42 * look.blush * bell(ax - 0.205, 0.07) * bell(hy - 0.355, 0.055));
    c = c.lerp(warm, 0.10 * look.blush * bell(x, 0.05) * bell(hy - 0.345, 0.03));
    c = c.lerp(darker(look.skin, 0.74), 0.40 * bell(ax - 0.135, 0.075) * bell(hy - 0.535, 0.03));
    c = c.lerp(darker(look.skin, 0.72), 0.45 * bell(ax - 0.066, 0.014) * bell(hy - 0.335, 0.024));
    c = c.lerp(darker(look.skin, 0.66), 0.50 * bell(x, 0.05) * bell(hy - 0.300, 0.012));
    c = c.lerp(darker(look.skin, 0.45), 0.75 * bell(ax - 0.030, 0.011) * bell(hy - 0.308, 0.008));
    c = c.lerp(look.skin * 1.08, 0.5 * bell(x, 0.018) * smoothstep(0.32, 0.36, hy) * smoothstep(0.52, 0.44, hy));
    c = c.lerp(darker(look.skin, 0.76), 0.45 * bell(x, 0.05) * bell(hy - 0.137, 0.012));
    if look.age > 0.0 {
        let fold = bell(ax - 0.085 - 0.4 * (0.30 - hy).max(0.0), 0.007)
            * smoothstep(0.20, 0.24, hy)
            * smoothstep(0.33, 0.29, hy);
        let brow = smoothstep(0.2, 0.1, ax) * (bell(hy - 0.665, 0.005) + bell(hy - 0.70, 0.005));
        let bag = bell(hy - 0.445 + 0.8 * (ax - 0.155) * (ax - 0.155) * 4.0, 0.006) * bell(ax - 0.155, 0.05);
        c = c.lerp(darker(look.skin, 0.68), look.age * (fold + 0.7 * brow + bag).min(1.0));
    }
    if look.freckles {
        // One freckle in some cells of a grid, each a little out of place.
        let (i, j) = (libm::floorf(x / 0.026), libm::floorf(hy / 0.022));
        let chance = |k: f32| {
            let v = libm::sinf(i * 12.9898 + j * 78.233 + k) * 43758.547;
            v - libm::floorf(v)
        };
        let dx = x / 0.026 - i - mix(0.3, 0.7, chance(1.0));
        let dy = hy / 0.022 - j - mix(0.3, 0.7, chance(2.0));
        let place = bell(ax - 0.12, 0.075) * bell(hy - 0.385, 0.035);
        if chance(3.0) < 0.8 * place {
            c = c.lerp(darker(look.skin, 0.74), 0.55 * smoothstep(0.24, 0.12, libm::sqrtf(dx * dx + dy * dy)));
        }
    }
    let (c, at) = mouth(look, c, x, hy);
    if at != region::SKIN {
        return (c, at);
    }
    eyes(look, c, x, hy)
}

/// The beard's colour: strands that run down from the cheek.
fn beard(look: &Look, ax: f32, hy: f32, degrees: f32, around: f32) -> Vec3 {
    let strand = libm::sinf(around * 330.0 + 3.0 * libm::sinf(hy * 21.0)) * smoothstep(100.0, 60.0, degrees);
    look.hair * (0.86 + 0.07 * strand + 0.10 * smoothstep(0.0, 0.25, hy) * smoothstep(0.0, 0.2, ax))
}

/// How much of the spot the beard covers: jaw, chin and moustache, not the throat, the lips and the upper cheek.
fn beard_share(ax: f32, hy: f32, degrees: f32) -> f32 {
    let cheek = mix(0.23, 0.45, smoothstep(0.14, 0.37, ax));
    let jaw = -0.035 + 0.20 * smoothstep(35.0, 95.0, degrees);
    let sideburn = smoothstep(100.0, 94.0, degrees);
    let full = smoothstep(cheek + 0.012, cheek - 0.012, hy) * smoothstep(jaw - 0.012, jaw + 0.012, hy) * sideburn;
    let bare = bell(ax, 0.085) * bell(hy - 0.20, 0.030);
    let full = full * (1.0 - smoothstep(0.45, 0.65, bare));
    let lip = (hy - 0.250 + 1.6 * ax * ax).abs();
    let moustache = smoothstep(0.030, 0.020, lip) * smoothstep(0.145, 0.12, ax) * smoothstep(90.0, 80.0, degrees);
    if hy > 0.224 && ax < 0.10 { moustache } else { full.max(moustache) }
}

fn mouth(look: &Look, c: Vec3, x: f32, hy: f32) -> (Vec3, u8) {
    let wide = 0.098;
    let t = x / wide;
    if t.abs() > 1.08 {
        return (c, region::SKIN);
    }
    let line = 0.196 + 0.020 * t * t - 0.004 * bell(t, 0.2);
    let shape = (1.0 - t * t).max(0.0);
    let upper = line + (0.021 - 0.006 * bell(t, 0.14)) * libm::sqrtf(shape);
    let lower = line - 0.033 * shape;
    let gap = (hy - line).abs();
    let mut out = c;
    let mut at = region::SKIN;
    if hy < upper && hy > lower {
        let shade = if hy > line { darker(look.lips, 0.86) } else { look.lips };
        let shine = 0.16 * bell(t, 0.3) * bell(hy - line + 0.017, 0.007);
        out = shade + Vec3::splat(shine);
        at = region::LIPS;
    }
    let stroke = smoothstep(0.0068, 0.0038, gap) * smoothstep(1.08, 0.95, t.abs());
    (out.lerp(darker(look.lips, 0.42), 0.9 * stroke), at)
}

fn eyes(look: &Look, c: Vec3, x: f32, hy: f32) -> (Vec3, u8) {
    let side = if x < 0.0 { -1.0 } else { 1.0 };
    let (ex, ey) = (0.152, 0.497);
    let dx = x.abs() - ex;
    let dy = hy - ey;
    let (wide, up, low) = (0.079 * look.eyes, 0.049 * look.eyes, 0.036 * look.eyes);
    // Almond: the outer corner a little higher than the inner one.
    let t = dx / wide;
    let slant = 0.006 * t;
    let shape = (1.0 - t * t).max(0.0);
    let lid = slant + up * libm::sqrtf(shape) * (1.0 - 0.12 * t);
    let floor = slant - low * shape;
    let mut out = c;
    let mut at = region::SKIN;
    if t.abs() < 1.0 && dy < lid && dy > floor {
        at = region::EYES;
        out = vec3(0.97, 0.96, 0.95) * mix(1.0, 0.78, smoothstep(lid - 0.026, lid, dy));
        let (ix, iy) = (dx + 0.004, dy - 0.004);
        let r = libm::sqrtf(ix * ix + iy * iy) / look.eyes;
        if r < 0.040 {
            out = look.iris.lerp(darker(look.iris, 0.5), smoothstep(0.030, 0.040, r) + 0.5 * smoothstep(0.0, 0.03, iy));
        }
        if r < 0.0185 {
            out = vec3(0.04, 0.03, 0.04);
        }
        let (gx, gy) = (dx * side - 0.014, dy - 0.019);
        if gx * gx + gy * gy < 0.0105 * 0.0105 {
            out = Vec3::ONE;
        }
    }
    // Lash line above, a fine one below, the fold of the lid.
    let near = smoothstep(1.22, 1.02, t.abs());
    let thick = 0.010 + 0.007 * look.lashes * smoothstep(-0.4, 1.0, t);
    if near > 0.0 && dy > lid - 0.004 && t > -1.1 {
        let edge = lid.max(slant - 0.002 + if t > 1.0 { 0.35 * (t - 1.0) * wide * look.lashes } else { 0.0 });
        let lash = smoothstep(thick + 0.003, thick - 0.003, (dy - edge).abs());
        out = out.lerp(darker(look.hair, 0.25), 0.95 * lash * near);
        let fold = bell(dy - edge - 0.027, 0.005) * smoothstep(1.1, 0.7, t.abs());
        out = out.lerp(darker(look.skin, 0.66), 0.5 * fold);
    }
    if t.abs() < 1.0 {
        out = out.lerp(darker(look.skin, 0.55), 0.5 * smoothstep(0.006, 0.002, (dy - floor).abs()));
    }
    // Brows.
    let b = (x.abs() - 0.160) / 0.098;
    if b.abs() < 1.0 {
        let arch = 0.612 + 0.020 * (1.0 - (b - 0.25) * (b - 0.25)) - 0.012 * smoothstep(0.3, -1.0, b) * 0.6;
        let width = 0.0145 * look.brows * mix(1.0, 0.45, smoothstep(-0.2, 1.0, b)) * smoothstep(1.0, 0.82, -b);
        let brow = smoothstep(width + 0.003, width - 0.003, (hy - arch).abs());
        if brow > 0.0 {
            out = out.lerp(darker(look.hair, 0.62), 0.92 * brow);
            if brow > 0.5 {
                at = region::HAIR;
            }
        }
    }
    (out, at)
}

fn ear(look: &Look, s: &Spot) -> Vec3 {
    let inner = smoothstep(0.55, 0.95, s.along);
    look.skin.lerp(darker(look.skin, 0.66), 0.6 * inner).lerp(vec3(0.86, 0.40, 0.33), 0.10)
}

fn hair(f: &Figure, look: &Look, s: &Spot) -> (Vec3, u8) {
    let h = f.head_m();
    let p = s.position;
    if s.part == part::HAIR {
        let hy = (p.y - f.chin_y()) / h;
        let z = (p.z - f.m_z(0.0)) / h;
        if let Some(band) = look.hair_band {
            let line = hy - 0.80 + 0.42 * (z - 0.1);
            if line.abs() < 0.055 {
                return (band * if line.abs() > 0.04 { 0.8 } else { 1.0 }, region::TRIM);
            }
        }
    } else if let Some(band) = look.hair_band
        && s.along < 0.10
    {
        return (band, region::TRIM);
    }
    let angle = s.around * core::f32::consts::TAU;
    let strand = libm::sinf(angle * 26.0 + 2.2 * libm::sinf(s.along * 9.0 + angle * 3.0))
        + 0.6 * libm::sinf(angle * 61.0 + 5.0 * s.along);
    let gloss = bell(s.normal.y - 0.62, 0.13) * 0.16;
    let c = look.hair * (1.0 + 0.085 * strand) + look.hair * gloss * 1.4 + Vec3::splat(0.25 * gloss * gloss);
    (c, region::HAIR)
}

fn trunk(f: &Figure, look: &Look, s: &Spot) -> (Vec3, u8) {
    let low = f.trunk_y(0.0);
    let t = (s.position.y - low) / (f.trunk_y(1.0) - low);
    let h = f.build.height / 1.7;
    let x = s.position.x / h;
    let front = s.position.z > 0.0;
    let seat = |c: Vec3| {
        let fly = front && x.abs() < 0.004 && t > 0.02;
        let pocket = front && (x.abs() - 0.10 + 0.25 * (t - 0.12)).abs() < 0.004 && t > 0.09;
        let back_pocket = !front && (x.abs() - 0.075).abs() < 0.042 && (t - 0.10).abs() < 0.062;
        let rim = back_pocket && ((x.abs() - 0.075).abs() > 0.037 || (t - 0.10).abs() > 0.054);
        if fly || pocket || rim { darker(c, 0.72) } else { c }
    };
    // Under a patterned skirt the hips are plain.
    let legs = match look.legs {
        Cloth::Bands(ground, ..) => ground,
        _ => look.legs.at(low - s.position.y + 0.02, s.around, 1.0),
    };
    if t < look.hem {
        if let Some(belt) = look.belt
            && t > look.hem - 0.085
        {
            let buckle = front && x.abs() < 0.024;
            let hole = buckle && x.abs() < 0.014 && (t - look.hem + 0.042).abs() < 0.022;
            return (
                if hole {
                    darker(belt, 0.6)
                } else if buckle {
                    rgb(0xd9b65a)
                } else {
                    belt
                },
                region::TRIM,
            );
        }
        return (seat(legs), region::LEGWEAR);
    }
    // On top of the shoulders the cloth is measured outwards from the neck, where height hardly changes.
    let out = libm::sqrtf(s.position.x * s.position.x + s.position.z * s.position.z);
    let yoke = 0.85 * smoothstep(0.84, 0.97, t) * (0.17 * h - out);
    let mut c = look.top.at(s.position.y + yoke, s.around, 1.0);
    // Shade below the arms and the bust.
    c = darker(c, 1.0 - 0.12 * bell(s.around.min(1.0 - s.around) - 0.25, 0.05) * bell(t - 0.64, 0.1));
    match look.front {
        Front::Plain => {}
        Front::Buttons(trim) => {
            if front && x.abs() < 0.017 {
                let gap = (s.position.y / h) / 0.075;
                let d = (gap - libm::roundf(gap)) * 0.075;
                if x * x + d * d < 0.0072 * 0.0072 {
                    return (trim, region::TRIM);
                }
                c = if x.abs() > 0.0145 { darker(c, 0.66) } else { c * 1.05 };
            }
        }
        Front::Bib => {
            let bib = if front {
                x.abs() < 0.105 - 0.03 * (t - 0.45) && t < 0.74
            } else {
                x.abs() < 0.11 - 0.35 * (t - 0.3).max(0.0) && t < 0.62
            };
            let strap = (x.abs() - if front { 0.078 } else { 0.03 + 0.055 * smoothstep(0.6, 0.95, t) }).abs() < 0.019
                && t > 0.6;
            if front && t > 0.68 && t < 0.725 && (x.abs() - 0.078).abs() < 0.016 {
                return (rgb(0xe2c06a), region::TRIM);
            }
            if bib || strap {
                let pocket = front && x.abs() < 0.055 && t > 0.48 && t < 0.64;
                let seam = pocket && (x.abs() > 0.050 || !(0.492..=0.615).contains(&t));
                return (if seam { darker(legs, 0.7) } else { legs }, region::LEGWEAR);
            }
        }
        Front::Braces(trim) => {
            let place = if front { 0.092 } else { 0.02 + 0.08 * smoothstep(0.45, 0.95, t) };
            if (x.abs() - place).abs() < 0.018 {
                let stitch = (x.abs() - place).abs() > 0.0145;
                return (if stitch { darker(trim, 0.75) } else { trim }, region::TRIM);
            }
        }
        Front::Waistcoat(cloth, tie) => {
            let open = front && x.abs() < 0.115 * smoothstep(0.60, 1.02, t);
            let arm_hole = x.abs() > 0.158 && t > 0.62;
            if front && x.abs() < mix(0.020, 0.032, smoothstep(0.95, 0.6, t)) && t > 0.60 {
                let weave = libm::sinf((s.position.y + x) * 260.0) > 0.2;
                return (if weave { tie } else { darker(tie, 0.75) }, region::TRIM);
            }
            if !open && !arm_hole {
                let gap = (s.position.y / h) / 0.07;
                let d = (gap - libm::roundf(gap)) * 0.07;
                if front && t < 0.62 && x * x + d * d < 0.008 * 0.008 {
                    return (rgb(0xd9b65a), region::TRIM);
                }
                let edge =
                    front && (x.abs() < 0.003 || (t > 0.60 && x.abs() < 0.115 * smoothstep(0.60, 1.02, t) + 0.006));
                let bone =
                    libm::sinf(s.around * 48.0 * core::f32::consts::TAU) * libm::sinf(s.position.y * 420.0) > 0.35;
                let c = if bone { cloth * 1.13 } else { cloth };
                return (if edge { darker(c, 0.65) } else { c }, region::TRIM);
            }
        }
    }
    // A round neck on bare skin.
    if look.collar.is_none() {
        let neck = 0.985 - if front { 0.075 * bell(x, 0.055) } else { 0.0 };
        if t > neck {
            return (look.skin, region::SKIN);
        }
        if t > neck - 0.014 {
            return (darker(look.top.ground(), 0.78), region::TOP);
        }
    } else if let Some(collar) = look.collar {
        let points = front
            && t > 0.90
            && x.abs() < 0.075
            && t > 0.985 - 0.085 * smoothstep(0.075, 0.02, x.abs()) * smoothstep(0.004, 0.02, x.abs());
        if points || t > 0.988 {
            return (collar, region::TOP);
        }
        if front && look.front != Front::Plain && x.abs() < 0.010 && t > 0.94 {
            return (darker(look.skin, 0.85), region::SKIN);
        }
    }
    (c, region::TOP)
}

fn arm(f: &Figure, look: &Look, s: &Spot) -> (Vec3, u8) {
    if s.along < look.sleeve {
        let y = f.shoulder().y - s.along * f.build.arm * f.build.height;
        let c = look.top.at(y, s.around, 0.42);
        let c = if s.along > look.sleeve - 0.045 { darker(c, 0.82) } else { c };
        return (c, region::TOP);
    }
    let shade = smoothstep(look.sleeve + 0.05, look.sleeve, s.along);
    (look.skin.lerp(darker(look.skin, 0.72), 0.6 * shade), region::SKIN)
}

fn hand(look: &Look, s: &Spot) -> Vec3 {
    let mut c = look.skin.lerp(vec3(0.86, 0.42, 0.35), 0.07);
    // Palms are paler.
    c = c.lerp(look.skin * 1.12, 0.6 * smoothstep(0.2, -0.7, s.normal.y));
    c
}

fn leg(f: &Figure, look: &Look, s: &Spot) -> (Vec3, u8) {
    let length = f.leg_at(0.0).y - f.leg_at(1.0).y;
    if s.along < look.trouser {
        let c = look.legs.at(s.along * length + 0.02, s.around + 0.02, 0.62);
        let hem = s.along > look.trouser - 0.03;
        return (if hem { darker(c, 0.8) } else { c }, region::LEGWEAR);
    }
    if s.along < look.shoe {
        let shade = smoothstep(look.trouser + 0.05, look.trouser, s.along);
        return (look.skin.lerp(darker(look.skin, 0.72), 0.6 * shade), region::SKIN);
    }
    let top = s.along < look.shoe + 0.03;
    (if top { darker(look.shoes, 0.78) } else { look.shoes }, region::SHOES)
}

fn shoe(f: &Figure, look: &Look, s: &Spot) -> (Vec3, u8) {
    let h = f.build.height / 1.7;
    let y = s.position.y / h;
    if y < 0.020 {
        return (if y > 0.017 { darker(look.soles, 0.7) } else { look.soles }, region::SHOES);
    }
    let ankle = f.leg_at(1.0);
    let (x, z) = ((s.position.x - ankle.x) / h, (s.position.z - ankle.z) / h);
    let mid = x - 0.16 * z;
    let lace = z > 0.055 && z < 0.135 && mid.abs() < 0.020 && libm::sinf(z * 300.0) > 0.1;
    let cap = z > 0.165;
    if lace {
        return (look.soles.lerp(Vec3::ONE, 0.3), region::SHOES);
    }
    (if cap { darker(look.shoes, 0.82) } else { look.shoes }, region::SHOES)
}
