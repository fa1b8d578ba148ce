//! Random numbers that are a hash of who and what for: the same person gets the same ones every time.

/// What a hash is for, so that one person's numbers do not depend on each other.
#[derive(Clone, Copy)]
pub(crate) enum Purpose {
    Character = 1,
    Clip,
    Phase,
    Yaw,
    Scale,
    X,
    Z,
    Pace,
    Start,
    Stay,
    Way,
    Schedule,
}

/// The random numbers of one person.
pub(crate) struct Dice {
    pub(crate) seed: u32,
    pub(crate) index: u32,
}

impl Dice {
    /// 32 random bits: two rounds of the PCG output permutation (O'Neill 2014), as shaders use it.
    pub(crate) fn bits(&self, purpose: Purpose) -> u32 {
        let seeded = permute(self.seed.wrapping_mul(0x9E37_79B9) ^ purpose as u32);
        permute(permute(self.index ^ seeded).wrapping_add(seeded))
    }

    /// 0 to below 1.
    pub(crate) fn unit(&self, purpose: Purpose) -> f32 {
        (self.bits(purpose) >> 8) as f32 / (1 << 24) as f32
    }

    /// -1 to below 1.
    pub(crate) fn around_zero(&self, purpose: Purpose) -> f32 {
        self.unit(purpose) * 2.0 - 1.0
    }

    /// 0 to below `end`, which is not 0.
    pub(crate) fn below(&self, purpose: Purpose, end: u32) -> u32 {
        ((u64::from(self.bits(purpose)) * u64::from(end)) >> 32) as u32
    }
}

fn permute(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}
