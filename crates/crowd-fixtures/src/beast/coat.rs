//! What an animal's coat looks like: stripes, dark marks, eyes, hooves.

use glam::Vec3;

use super::{Kind, Ring, TAU, head_frame, part};
use crate::atlas::Spot;
use crate::paint_human::{region, rgb};
use crate::profile::{bell, mix, smoothstep};

/// Colour and region of a spot of an animal.
pub(super) fn coat(kind: Kind, list: &[Ring], s: &Spot) -> (Vec3, u8) {
    let (poll, along, up) = head_frame(list);
    let p = s.position;
    let ahead = (p - poll).dot(along);
    let above = (p - poll).dot(up);
    let shade = mix(0.82, 1.04, 0.5 + 0.5 * s.normal.y);
    let zebra = kind == Kind::Zebra;
    let (pale, dark) = if zebra { (rgb(0xf3eee2), rgb(0x24201f)) } else { (rgb(0x8d6f55), rgb(0x3a2c25)) };
    let on_head = s.part == part::BODY && ahead > -0.02 && p.z > list[11].z;
    let (mut c, mut at) = match s.part {
        part::HORN => (rgb(0x4a4038).lerp(rgb(0xb9a98c), smoothstep(0.0, 0.35, s.along) * 0.6), region::HORN),
        part::EAR => {
            let inner = smoothstep(0.25, 0.5, s.along) * smoothstep(0.98, 0.8, s.along);
            (pale.lerp(dark, if s.along > 0.78 { 0.9 } else { 0.25 * inner }), region::COAT)
        }
        part::TAIL => (
            if s.along > 0.48 { dark } else { stripes(kind, pale, dark, s.along * 16.0) },
            if s.along > 0.48 { region::HAIR } else { region::COAT },
        ),
        part::MANE => {
            let strand = 0.85 + 0.15 * libm::sinf(s.along * 150.0);
            (if zebra { stripes(kind, pale, dark, s.along * 13.0) } else { dark * strand }, region::HAIR)
        }
        part::LEG => {
            if s.along > 0.928 {
                (rgb(0x2b2623), region::SHOES)
            } else if zebra {
                (stripes(kind, pale, dark, s.along * 15.0), region::COAT)
            } else {
                (pale.lerp(dark, smoothstep(0.35, 0.75, s.along) * 0.8), region::COAT)
            }
        }
        _ => (body_coat(kind, list, pale, dark, s, p), region::COAT),
    };
    if on_head {
        if zebra {
            c = stripes(kind, pale, dark, ahead * 26.0 + 14.0 * p.x.abs());
        } else {
            c = dark.lerp(pale, 0.25);
        }
        let muzzle = smoothstep(0.30, 0.345, ahead);
        c = c.lerp(if zebra { rgb(0x3a3230) } else { rgb(0x2a211d) }, muzzle);
        // Nostrils and mouth.
        let nostril = bell(p.x.abs() - 0.032, 0.012) * bell(ahead - 0.40, 0.016) * smoothstep(-0.02, 0.01, above);
        c = c.lerp(rgb(0x0d0a0a), 0.9 * nostril);
        let eye = libm::sqrtf((ahead - 0.115) * (ahead - 0.115) + 1.6 * (above - 0.045) * (above - 0.045));
        if p.x.abs() > 0.05 {
            c = c.lerp(dark * 0.6, smoothstep(0.046, 0.034, eye));
            if eye < 0.024 {
                c = rgb(0x120c0a);
                at = region::EYES;
            }
            let (gx, gy) = (ahead - 0.108, above - 0.054);
            if gx * gx + gy * gy < 0.007 * 0.007 {
                c = rgb(0xf8f8f8);
            }
        }
    }
    if at == region::COAT && is_dark(c, pale, dark) {
        at = region::MARKS;
    }
    (c * shade, at)
}

fn is_dark(c: Vec3, pale: Vec3, dark: Vec3) -> bool {
    c.distance_squared(dark) < c.distance_squared(pale)
}

fn stripes(kind: Kind, pale: Vec3, dark: Vec3, x: f32) -> Vec3 {
    if kind == Kind::Gnu {
        return pale;
    }
    let w = libm::sinf(TAU * x * 0.5);
    pale.lerp(dark, smoothstep(-0.08, 0.12, w))
}

fn body_coat(kind: Kind, list: &[Ring], pale: Vec3, dark: Vec3, s: &Spot, p: Vec3) -> Vec3 {
    let belly = around_belly(s.around);
    if kind == Kind::Zebra {
        let wobble = 0.25 * libm::sinf(p.y * 17.0 + 3.0 * s.along) + 0.18 * libm::sinf(p.z * 9.0 + p.y * 6.0);
        // Behind the groin the stripes fan out round it: upright on the flank, level on the haunch.
        let (back, high) = (-0.40 - p.z, p.y - 0.76);
        let fan = 14.0 * 0.41 - 5.4 * libm::atan2f(back, high);
        let x =
            if back > 0.0 { mix(s.along * 14.0, fan, smoothstep(0.0, 0.12, back)) } else { s.along * 14.0 } + wobble;
        let c = stripes(kind, pale, dark, x);
        let back = bell(around_belly(s.around) - 0.5, 0.012);
        return c.lerp(pale, 0.9 * smoothstep(0.09, 0.03, belly)).lerp(dark, back);
    }
    // Plain: paler flank, dark face and chest, faint brindle on the shoulder.
    let front = smoothstep(list[4].z, list[8].z, p.z);
    let brindle = smoothstep(0.55, 0.8, libm::sinf(s.along * 62.0 + 2.0 * libm::sinf(p.y * 9.0)))
        * bell(p.z - 0.45, 0.22)
        * smoothstep(0.15, 0.3, belly);
    let c = pale.lerp(dark, 0.10 + 0.25 * front * smoothstep(0.25, 0.0, belly));
    c.lerp(dark, 0.55 * brindle).lerp(dark, 0.35 * bell(belly - 0.5, 0.05))
}

/// Turns away from the belly line, 0..0.5.
fn around_belly(around: f32) -> f32 {
    let x = around - 0.5 - libm::floorf(around - 0.5);
    x.min(1.0 - x)
}
