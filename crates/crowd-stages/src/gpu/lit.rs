//! Pipelines of what the sun shines on, with shadows and without: frames that have none pay for no look at a map.

use std::sync::OnceLock;

/// Both, each made when a frame first asks for it.
pub(crate) struct Lit {
    make: Box<dyn Fn(bool) -> wgpu::RenderPipeline + Send + Sync>,
    plain: OnceLock<wgpu::RenderPipeline>,
    shaded: OnceLock<wgpu::RenderPipeline>,
}

impl Lit {
    /// `make` is told whether there are shadows: the shaders' constant [`has_shadows`].
    pub(crate) fn new(make: impl Fn(bool) -> wgpu::RenderPipeline + Send + Sync + 'static) -> Self {
        Self { make: Box::new(make), plain: OnceLock::new(), shaded: OnceLock::new() }
    }

    /// The one for a frame with or without shadows.
    pub(crate) fn of(&self, shows_shadows: bool) -> &wgpu::RenderPipeline {
        let place = if shows_shadows { &self.shaded } else { &self.plain };
        place.get_or_init(|| (self.make)(shows_shadows))
    }
}

/// The constant of `shaders/shared/shadow.wgsl`.
pub(crate) fn has_shadows(shows_shadows: bool) -> (&'static str, f64) {
    ("HAS_SHADOWS", f64::from(u8::from(shows_shadows)))
}
