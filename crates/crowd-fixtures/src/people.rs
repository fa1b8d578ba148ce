//! The cast: who they are, how they are built, what they wear.

use crate::body::{Build, cover};
use crate::human_clips::Manner;
use crate::paint_human::{Cloth, Front, Look, rgb};
pub use crate::person::{Person, Tail};
use crate::wear::{HairCut, Skirt};

/// Trunk rings of a slim adult: share of the way up, half width, front, back (body heights).
const TRUNK: [[f32; 4]; 10] = [
    [0.0, 0.098, 0.058, 0.070],
    [0.12, 0.104, 0.058, 0.078],
    [0.235, 0.096, 0.058, 0.066],
    [0.37, 0.077, 0.054, 0.052],
    [0.51, 0.081, 0.058, 0.055],
    [0.635, 0.088, 0.062, 0.062],
    [0.73, 0.094, 0.062, 0.066],
    [0.84, 0.098, 0.052, 0.062],
    [0.93, 0.088, 0.038, 0.050],
    [1.0, 0.047, 0.030, 0.040],
];

fn slim() -> Build {
    Build {
        height: 1.70,
        head: 0.140,
        head_width: 0.95,
        crotch: 0.475,
        neck_base: 0.833,
        shoulder: 0.094,
        trunk: TRUNK.to_vec(),
        bust: 0.022,
        neck: 0.0265,
        arm_girth: 0.86,
        leg_girth: 1.0,
        arm: 0.315,
        trunk_covers: vec![cover(0.225, 0.004, 0.0), cover(9.0, 0.006, 0.0)],
        arm_covers: vec![cover(0.50, 0.004, 0.0), cover(9.0, 0.0, 0.0)],
        leg_covers: vec![cover(0.64, 0.003, 0.0), cover(9.0, 0.008, 0.0)],
        jaw: 0.95,
        nose: 0.85,
        beard: 0.0,
        eyes: 0.0,
        columns: 16,
        rows: 1,
        hole: (2, 3),
        crotch_columns: 1,
    }
}

/// A slim woman with a pony tail, in a plaid shirt, jeans and boots: the paper's triangle count.
pub fn mara() -> Person {
    Person {
        name: "mara",
        build: slim(),
        look: Look {
            skin: rgb(0xf0c3a0),
            hair: rgb(0x9a4420),
            iris: rgb(0x3f8f62),
            lips: rgb(0xcf5b56),
            blush: 1.0,
            lashes: 1.0,
            eyes: 1.08,
            brows: 0.9,
            hairline: vec![
                (0.0, 0.83),
                (35.0, 0.80),
                (62.0, 0.66),
                (78.0, 0.52),
                (100.0, 0.40),
                (130.0, 0.16),
                (180.0, 0.08),
            ],
            beard: 0.0,
            age: 0.0,
            freckles: true,
            top: Cloth::Plaid(rgb(0xb8342f), rgb(0x2a2336), rgb(0xf3e3bf), 0.125, 8.0),
            legs: Cloth::Denim(rgb(0x2f4a7a), rgb(0x7f9ec4)),
            shoes: rgb(0x6b4226),
            soles: rgb(0x2f2019),
            belt: Some(rgb(0x4a2c1a)),
            front: Front::Buttons(rgb(0xf4ead2)),
            collar: Some(rgb(0xa82c29)),
            sleeve: 0.50,
            trouser: 0.64,
            shoe: 0.64,
            hem: 0.225,
            hair_band: Some(rgb(0x2f8f8a)),
        },
        hair: HairCut {
            rim: vec![
                (0.0, 0.80),
                (30.0, 0.78),
                (58.0, 0.64),
                (74.0, 0.50),
                (92.0, 0.44),
                (110.0, 0.36),
                (140.0, 0.16),
                (180.0, 0.10),
            ],
            thick: (0.030, 0.055),
            locks: (0.010, 7.0),
            hang: 0.42,
            columns: 18,
            rows: 7,
            sweep: 0.05,
        },
        tail: Tail::Pony(0.95, 0.13),
        ear_columns: 6,
        skirt: None,
        manner: Manner { walk_seconds: 1.06, step: 0.72, sway: 1.3, swing: 1.0, arms_out: 9.0, stoop: 0.0 },
        strong: "sit",
        texels: 512,
    }
}

/// A heavy man with a full beard, in a striped shirt and braces.
pub fn oskar() -> Person {
    let trunk = [
        [0.0, 0.116, 0.082, 0.084],
        [0.12, 0.126, 0.100, 0.092],
        [0.235, 0.132, 0.116, 0.086],
        [0.37, 0.133, 0.124, 0.082],
        [0.51, 0.130, 0.118, 0.080],
        [0.635, 0.126, 0.102, 0.080],
        [0.73, 0.124, 0.088, 0.082],
        [0.84, 0.120, 0.070, 0.078],
        [0.93, 0.104, 0.048, 0.062],
        [1.0, 0.058, 0.036, 0.050],
    ];
    let base = mara();
    Person {
        name: "oskar",
        build: Build {
            height: 1.78,
            head: 0.137,
            head_width: 1.06,
            crotch: 0.455,
            neck_base: 0.838,
            shoulder: 0.113,
            trunk: trunk.to_vec(),
            bust: 0.0,
            neck: 0.038,
            arm_girth: 1.32,
            leg_girth: 1.22,
            arm: 0.32,
            trunk_covers: vec![cover(0.215, 0.004, 0.0), cover(9.0, 0.008, 0.0)],
            arm_covers: vec![cover(0.40, 0.009, 0.0), cover(9.0, 0.0, 0.0)],
            leg_covers: vec![cover(0.95, 0.006, 0.038), cover(9.0, 0.003, 0.0)],
            jaw: 1.10,
            nose: 1.15,
            beard: 0.055,
            columns: 24,
            crotch_columns: 1,
            ..slim()
        },
        look: Look {
            skin: rgb(0xe0a987),
            hair: rgb(0x5a3a26),
            iris: rgb(0x4f7fae),
            lips: rgb(0xb8655a),
            blush: 0.9,
            lashes: 0.0,
            eyes: 0.92,
            brows: 1.5,
            hairline: vec![
                (0.0, 0.86),
                (35.0, 0.85),
                (60.0, 0.72),
                (78.0, 0.50),
                (100.0, 0.40),
                (130.0, 0.16),
                (180.0, 0.10),
            ],
            beard: 1.0,
            freckles: false,
            top: Cloth::Stripes(rgb(0xf1e7d0), rgb(0x2b6e7a), 0.085, 0.5),
            legs: Cloth::Plain(rgb(0x6e5a41)),
            shoes: rgb(0x33302f),
            soles: rgb(0x8c6a45),
            belt: None,
            front: Front::Braces(rgb(0xa8402f)),
            collar: None,
            sleeve: 0.40,
            trouser: 0.95,
            shoe: 0.95,
            hem: 0.215,
            hair_band: None,
            ..base.look
        },
        hair: HairCut {
            rim: vec![
                (0.0, 0.845),
                (30.0, 0.85),
                (52.0, 0.76),
                (70.0, 0.60),
                (88.0, 0.48),
                (105.0, 0.40),
                (140.0, 0.18),
                (180.0, 0.12),
            ],
            thick: (0.012, 0.032),
            locks: (0.006, 9.0),
            hang: 0.0,
            columns: 20,
            rows: 6,
            sweep: 0.0,
        },
        tail: Tail::None,
        ear_columns: 8,
        manner: Manner { walk_seconds: 1.22, step: 0.64, sway: 1.5, swing: 0.8, arms_out: 17.0, stoop: -3.0 },
        strong: "sit",
        ..base
    }
}

/// A child of seven in dungarees.
pub fn pip() -> Person {
    let trunk = [
        [0.0, 0.104, 0.070, 0.074],
        [0.12, 0.106, 0.070, 0.078],
        [0.235, 0.104, 0.074, 0.070],
        [0.37, 0.100, 0.076, 0.066],
        [0.51, 0.098, 0.072, 0.066],
        [0.635, 0.098, 0.068, 0.068],
        [0.73, 0.098, 0.062, 0.068],
        [0.84, 0.096, 0.054, 0.064],
        [0.93, 0.086, 0.042, 0.052],
        [1.0, 0.048, 0.033, 0.040],
    ];
    let base = mara();
    Person {
        name: "pip",
        build: Build {
            height: 1.24,
            head: 0.200,
            head_width: 1.08,
            crotch: 0.42,
            neck_base: 0.776,
            shoulder: 0.094,
            trunk: trunk.to_vec(),
            bust: 0.0,
            neck: 0.031,
            arm_girth: 1.04,
            leg_girth: 1.08,
            arm: 0.288,
            trunk_covers: vec![cover(9.0, 0.006, 0.0)],
            arm_covers: vec![cover(0.94, 0.005, 0.0), cover(9.0, 0.0, 0.0)],
            leg_covers: vec![cover(0.86, 0.007, 0.040), cover(9.0, 0.003, 0.0)],
            jaw: 1.08,
            nose: 0.5,
            ..slim()
        },
        look: Look {
            skin: rgb(0xf6d0b0),
            hair: rgb(0xe0b050),
            iris: rgb(0x5a8fd0),
            lips: rgb(0xd77a72),
            blush: 1.5,
            lashes: 0.3,
            eyes: 1.34,
            brows: 0.7,
            hairline: vec![
                (0.0, 0.80),
                (35.0, 0.78),
                (62.0, 0.66),
                (78.0, 0.52),
                (100.0, 0.36),
                (130.0, 0.16),
                (180.0, 0.08),
            ],
            freckles: true,
            top: Cloth::Stripes(rgb(0xf6efe0), rgb(0xd9573f), 0.062, 0.42),
            legs: Cloth::Denim(rgb(0x3d7a5c), rgb(0x6fa587)),
            shoes: rgb(0xe8b23a),
            soles: rgb(0xf3eee2),
            belt: None,
            front: Front::Bib,
            collar: None,
            sleeve: 0.94,
            trouser: 0.86,
            shoe: 0.93,
            hem: 0.30,
            hair_band: None,
            ..base.look
        },
        hair: HairCut {
            rim: vec![
                (0.0, 0.72),
                (25.0, 0.74),
                (50.0, 0.66),
                (68.0, 0.50),
                (90.0, 0.40),
                (110.0, 0.28),
                (140.0, 0.12),
                (180.0, 0.06),
            ],
            thick: (0.035, 0.075),
            locks: (0.024, 9.0),
            hang: 0.2,
            columns: 26,
            rows: 7,
            sweep: 0.05,
        },
        tail: Tail::None,
        manner: Manner { walk_seconds: 0.86, step: 0.76, sway: 1.0, swing: 1.3, arms_out: 13.0, stoop: -2.0 },
        strong: "sit",
        ..base
    }
}

/// A tall old man in a waistcoat and tie.
pub fn anselm() -> Person {
    let trunk = [
        [0.0, 0.096, 0.058, 0.066],
        [0.12, 0.099, 0.060, 0.070],
        [0.235, 0.096, 0.064, 0.062],
        [0.37, 0.092, 0.066, 0.056],
        [0.51, 0.094, 0.066, 0.058],
        [0.635, 0.100, 0.068, 0.066],
        [0.73, 0.104, 0.064, 0.070],
        [0.84, 0.106, 0.054, 0.068],
        [0.93, 0.095, 0.040, 0.054],
        [1.0, 0.048, 0.031, 0.042],
    ];
    let base = mara();
    Person {
        name: "anselm",
        build: Build {
            height: 1.90,
            head: 0.129,
            head_width: 0.98,
            crotch: 0.482,
            neck_base: 0.846,
            shoulder: 0.102,
            trunk: trunk.to_vec(),
            bust: 0.0,
            neck: 0.0285,
            arm_girth: 0.94,
            leg_girth: 0.90,
            arm: 0.325,
            trunk_covers: vec![cover(0.225, 0.004, 0.0), cover(9.0, 0.009, 0.0)],
            arm_covers: vec![cover(0.97, 0.005, 0.0), cover(9.0, 0.0, 0.0)],
            leg_covers: vec![cover(0.95, 0.005, 0.033), cover(9.0, 0.003, 0.0)],
            jaw: 1.0,
            nose: 1.3,
            beard: 0.03,
            ..slim()
        },
        look: Look {
            skin: rgb(0xe9bd9f),
            hair: rgb(0xcfcbc4),
            iris: rgb(0x6a7f8c),
            lips: rgb(0xb9736a),
            blush: 0.7,
            lashes: 0.0,
            eyes: 0.9,
            brows: 1.7,
            hairline: vec![
                (0.0, 0.92),
                (30.0, 0.90),
                (55.0, 0.80),
                (75.0, 0.55),
                (100.0, 0.40),
                (130.0, 0.14),
                (180.0, 0.06),
            ],
            beard: 0.95,
            age: 1.0,
            freckles: false,
            top: Cloth::Plain(rgb(0xefeae0)),
            legs: Cloth::Pin(rgb(0x4b4a52), rgb(0x77757c), 40.0),
            shoes: rgb(0x2a1c17),
            soles: rgb(0x15110f),
            belt: None,
            front: Front::Waistcoat(rgb(0x5b3446), rgb(0xc79a3a)),
            collar: Some(rgb(0xf6f2ea)),
            sleeve: 0.97,
            trouser: 0.95,
            shoe: 0.95,
            hem: 0.225,
            hair_band: None,
        },
        hair: HairCut {
            rim: vec![
                (0.0, 0.90),
                (25.0, 0.885),
                (48.0, 0.80),
                (66.0, 0.64),
                (86.0, 0.47),
                (105.0, 0.36),
                (140.0, 0.12),
                (180.0, 0.04),
            ],
            thick: (0.028, 0.030),
            locks: (0.010, 8.0),
            hang: 0.0,
            columns: 20,
            rows: 6,
            sweep: 0.03,
        },
        tail: Tail::None,
        manner: Manner { walk_seconds: 1.28, step: 0.60, sway: 0.8, swing: 0.8, arms_out: 9.0, stoop: 12.0 },
        strong: "bend",
        ..base
    }
}

/// The fine mesh: a woman in an embroidered skirt and blouse, more than 20,000 triangles.
pub fn noor() -> Person {
    let mut trunk = TRUNK;
    for row in &mut trunk {
        row[1] *= 1.02;
    }
    let base = mara();
    Person {
        name: "noor",
        build: Build {
            height: 1.72,
            head: 0.137,
            head_width: 0.96,
            trunk: trunk.to_vec(),
            bust: 0.024,
            arm_covers: vec![cover(0.72, 0.008, 0.0), cover(9.0, 0.0, 0.0)],
            leg_covers: vec![cover(0.66, 0.0, 0.0), cover(9.0, 0.006, 0.0)],
            trunk_covers: vec![cover(0.32, -0.007, 0.0), cover(9.0, 0.006, 0.0)],
            nose: 0.95,
            eyes: 1.0,
            jaw: 0.97,
            columns: 32,
            rows: 3,
            hole: (4, 9),
            crotch_columns: 5,
            ..slim()
        },
        look: Look {
            skin: rgb(0x8a5436),
            hair: rgb(0x2b1c18),
            iris: rgb(0x6b3f1d),
            lips: rgb(0xb5484c),
            blush: 0.6,
            lashes: 1.2,
            eyes: 1.08,
            brows: 1.05,
            freckles: false,
            top: Cloth::Bands(rgb(0xf2e6cc), rgb(0xd07a2d), rgb(0x7a2330), 0.155, 14.0),
            legs: Cloth::Bands(rgb(0x1f5a63), rgb(0xe0a63a), rgb(0xb03a34), 0.165, 24.0),
            shoes: rgb(0x7d3b2a),
            soles: rgb(0x2b1a14),
            belt: None,
            front: Front::Plain,
            collar: None,
            sleeve: 0.72,
            trouser: -1.0,
            shoe: 0.66,
            hem: 0.30,
            hair_band: Some(rgb(0xe0a63a)),
            ..base.look
        },
        hair: HairCut {
            rim: vec![
                (0.0, 0.83),
                (30.0, 0.80),
                (58.0, 0.66),
                (74.0, 0.53),
                (92.0, 0.44),
                (110.0, 0.34),
                (140.0, 0.16),
                (180.0, 0.10),
            ],
            thick: (0.025, 0.050),
            locks: (0.006, 16.0),
            hang: 0.34,
            columns: 64,
            rows: 22,
            sweep: 0.0,
        },
        tail: Tail::Bun(0.21),
        ear_columns: 18,
        skirt: Some(Skirt {
            waist: 0.37,
            hem: 0.235,
            flare: (0.150, 0.145),
            folds: (0.055, 9.0),
            columns: 72,
            rows: 24,
        }),
        manner: Manner { walk_seconds: 1.10, step: 0.64, sway: 1.3, swing: 0.9, arms_out: 13.0, stoop: 0.0 },
        strong: "bend",
        texels: 1024,
    }
}

/// Everybody, in the order of the line-up.
pub fn cast() -> Vec<Person> {
    vec![mara(), oskar(), pip(), anselm(), noor()]
}
