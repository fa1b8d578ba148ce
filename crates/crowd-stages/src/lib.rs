//! The per-frame pipeline of a crowd: cull -> weigh -> select levels -> fit the budget, then as the [`Technique`] has it:
//! scan -> reform -> draw, or sort into buckets -> draw.
//!
//! Each stage stands four times under one name: `shaders/stages/<stage>.wgsl`, [`cpu`]`/<stage>.rs` (the twin, a plain
//! function that follows the paper), [`gpu`]`/<stage>.rs` (the dispatch) and `tests/twins/<stage>.rs`.
//! There is no window and no event loop in here: an engine hands in a device and a command encoder.
//!
//! # Embedding
//!
//! [`gpu::CrowdRenderer::encode_into`] draws the crowd into colour and depth that an engine has drawn into before and goes on with:
//!
//! ```no_run
//! use crowd_stages::gpu::{CrowdRenderer, RendererOptions, Targets};
//! use crowd_stages::{CrowdData, FrameConfig, FrameView, InstanceRecord, Technique, Weight, wgpu};
//!
//! # fn frame(device: &wgpu::Device, queue: &wgpu::Queue, color: &wgpu::TextureView, depth: &wgpu::TextureView,
//! # clip_from_world: glam::Mat4) -> Result<(), Box<dyn std::error::Error>> {
//! // Once: a pack, its buffers and pipelines for the engine's formats, and who stands where.
//! let pack = crowd_pack::Pack::open("crowd.crowdpack".as_ref())?;
//! let data = CrowdData::from_pack(&pack, 1024)?;
//! let options = RendererOptions {
//!     max_instances: 10_000,
//!     max_vertices: 2_000_000,
//!     max_triangles: 4_000_000,
//!     color_format: wgpu::TextureFormat::Bgra8UnormSrgb,
//!     sample_count: 4,
//!     depth_format: wgpu::TextureFormat::Depth24PlusStencil8,
//!     reverse_z: false,
//! };
//! let mut crowd = CrowdRenderer::new(device, queue, &data, options)?;
//! let someone = InstanceRecord { scale: 1.0, clip: data.characters[0].clip_offset, ..Default::default() };
//! crowd.set_instances(queue, &[someone])?;
//!
//! // Each frame: the camera, then the stages and the draw into the engine's own encoder.
//! let config = FrameConfig::from_camera(&FrameView {
//!     clip_from_world,
//!     eye: glam::Vec3::new(0.0, 1.7, 5.0),
//!     fov_y_rad: 0.8,
//!     viewport_height_px: 720.0,
//!     time_s: 0.0,
//!     budget: 1_000_000,
//!     alpha: 3.0,
//!     weight: Weight::Area,
//! });
//! // Dots and impostors for those a few pixels high, levels that keep still: as `crowdplay` does.
//! let config = config.with_usual_detail();
//! let mut encoder = device.create_command_encoder(&Default::default());
//! // ... the engine's passes up to here: walls, ground, sky ...
//! let targets = Targets { color, resolve: None, depth, size: (1280, 720) };
//! crowd.encode_into(device, queue, &mut encoder, &targets, &config, Technique::Bucketed)?;
//! // ... and what comes after: water, particles, resolving the samples.
//! queue.submit([encoder.finish()]);
//! if let Some(totals) = crowd.totals(device, false) {
//!     println!("{} of the crowd in view, {} triangles", totals.visible_count, totals.triangle_count);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Where there is no engine, [`gpu::CrowdRenderer::encode`] draws the same crowd with a sky, a ground and a depth of its own.
//!
//! - *The device* is the engine's. [`Technique::Bucketed`] needs the feature `INDIRECT_FIRST_INSTANCE`, which wgpu gives to those alone who ask
//!   for it, and large crowds need more than wgpu's default limits:
//!
//!   ```no_run
//!   # use crowd_stages::{gpu, wgpu};
//!   # async fn open(adapter: &wgpu::Adapter) -> Result<(wgpu::Device, wgpu::Queue), wgpu::RequestDeviceError> {
//!   adapter
//!       .request_device(&wgpu::DeviceDescriptor {
//!           required_features: gpu::wanted_features() & adapter.features(),
//!           required_limits: gpu::wanted_limits(&adapter.limits()),
//!           ..Default::default()
//!       })
//!       .await
//!   # }
//!   ```
//!
//!   Without it [`Error::Feature`] says so; [`Technique::Reform`] needs no feature. [`wgpu`] is the version that devices must be of.
//! - *Cameras* have depth 0 near and 1 far, or with [`gpu::RendererOptions::reverse_z`] 1 near and 0 far, infinite or not; one that goes the
//!   other way is refused ([`Error::DepthRange`]). The world is in metres, Y up.
//! - *Targets* of another format, size or number of samples than the renderer was made for are refused ([`Error::Target`]). One colour target;
//!   all of it is drawn into, there is no viewport. Colours are linear: sRGB formats encode them, others take them as they are.
//! - *Occlusion culling* ([`DrawOptions::occlusion`]) sees the engine's depth, so its walls hide people; the texture has `TEXTURE_BINDING`.
//! - *Light* is fixed: the sun ([`SUN_DIRECTION`]), its colour and that of sky and ground are numbers of `shaders/shared/light.wgsl`. The crowd's
//!   shadow maps shade the crowd (and [`gpu::CrowdRenderer::set_scenery`]'s triangles) alone: the engine's walls throw no shadow on people, and
//!   people none on its ground.
//!
//! # Instances that a simulator writes
//!
//! A simulator on the GPU hands its own buffer over, and how many there are may also be known on the GPU alone
//! ([`gpu::InstanceFeed`] has the layout):
//!
//! ```no_run
//! use crowd_stages::gpu::{CrowdRenderer, InstanceFeed};
//!
//! # fn feed(device: &wgpu::Device, queue: &wgpu::Queue, crowd: &mut CrowdRenderer, written: &wgpu::Buffer, count: &wgpu::Buffer)
//! # -> Result<(), Box<dyn std::error::Error>> {
//! // Once: a compute shader of the engine's own writes `InstanceRecord`s to `written` and their number to `count` every frame.
//! let feed = InstanceFeed {
//!     instances: written,
//!     count: Some(count),
//!     most: 10_000,
//!     bounds: Default::default(),
//!     characters: &[],
//! };
//! crowd.borrow_instances(device, queue, &feed)?;
//! // Each frame: the simulator's dispatches, then `crowd.encode(...)` as ever.
//! # Ok(())
//! # }
//! ```

mod buckets;
mod cascades;
pub mod cpu;
mod data;
mod dots;
pub mod gpu;
mod impostors;
mod layers;
mod origins;
mod points;
mod records;
mod shown_texels;
mod surface_colors;
mod technique;

pub use buckets::{Buckets, DISCRETE_SHARES, discrete_config};
pub use cascades::{CrowdBounds, SUN_DIRECTION, fit_cascades, shadow_side};
pub use data::{CrowdData, Error, Result, TextureLayer};
pub use dots::{DOT_COUNTS, dot_corners, dot_reach};
/// Of the version that cameras are of.
pub use glam;
pub use impostors::{IMPOSTOR_FADE, ImpostorMip, ImpostorPoses, Impostors, is_impostor};
pub use points::{MOST_POINTS, POINT_COUNTS, surface_points};
pub use records::*;
pub use technique::{DrawOptions, Fit, Levels, Skinning, Technique, View};
/// Of the version that devices must be of.
pub use wgpu;
