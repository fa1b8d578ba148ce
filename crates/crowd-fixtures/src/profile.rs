//! Smooth curves through a few hand-set values: radii along a limb, widths along a spine, angles along a gait.

/// A monotone cubic (Fritsch–Carlson) through `(position, value)` keys; constant outside them.
///
/// It never overshoots its keys, so a hem stays a hem and a wrist never gets thinner than it was drawn.
#[derive(Clone, Debug)]
pub struct Profile {
    keys: Vec<(f32, f32)>,
    slopes: Vec<f32>,
}

impl Profile {
    /// A curve through `keys`, whose positions must increase.
    pub fn new(keys: &[(f32, f32)]) -> Self {
        let n = keys.len();
        let secant = |i: usize| (keys[i + 1].1 - keys[i].1) / (keys[i + 1].0 - keys[i].0);
        let mut slopes = vec![0.0; n];
        for i in 0..n {
            if n < 2 || i == 0 || i + 1 == n {
                continue;
            }
            let (a, b) = (secant(i - 1), secant(i));
            if a * b > 0.0 {
                let (ha, hb) = (keys[i].0 - keys[i - 1].0, keys[i + 1].0 - keys[i].0);
                let (wa, wb) = (2.0 * hb + ha, hb + 2.0 * ha);
                slopes[i] = (wa + wb) / (wa / a + wb / b);
            }
        }
        if n >= 2 {
            slopes[0] = secant(0);
            slopes[n - 1] = secant(n - 2);
        }
        Self { keys: keys.to_vec(), slopes }
    }

    /// The value at position `x`.
    pub fn at(&self, x: f32) -> f32 {
        let n = self.keys.len();
        if x <= self.keys[0].0 {
            return self.keys[0].1;
        }
        if x >= self.keys[n - 1].0 {
            return self.keys[n - 1].1;
        }
        let i = self.keys.iter().rposition(|k| k.0 <= x).unwrap_or(0).min(n - 2);
        let ((x0, y0), (x1, y1)) = (self.keys[i], self.keys[i + 1]);
        let h = x1 - x0;
        let t = (x - x0) / h;
        let (t2, t3) = (t * t, t * t * t);
        y0 * (2.0 * t3 - 3.0 * t2 + 1.0)
            + self.slopes[i] * h * (t3 - 2.0 * t2 + t)
            + y1 * (3.0 * t2 - 2.0 * t3)
            + self.slopes[i + 1] * h * (t3 - t2)
    }
}

/// 0 below `a`, 1 above `b`, smooth between; `a` may be the larger one.
pub fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// `a` at `t` = 0, `b` at `t` = 1.
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// A bell of height 1 around 0 with half-width `s` (value 0.61 at `s`).
pub fn bell(x: f32, s: f32) -> f32 {
    libm::expf(-0.5 * (x / s) * (x / s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profile_passes_its_keys_and_does_not_overshoot() {
        let p = Profile::new(&[(0.0, 1.0), (1.0, 1.0), (1.1, 0.5), (2.0, 0.5)]);
        assert_eq!(p.at(0.0), 1.0);
        assert_eq!(p.at(2.0), 0.5);
        for i in 0..=200 {
            let y = p.at(i as f32 * 0.01);
            assert!((0.5 - 1e-6..=1.0 + 1e-6).contains(&y), "{y} at {i}");
        }
    }
}
