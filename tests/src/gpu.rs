//! A GPU to run single stages on: buffers from slices, a pass, buffers back to slices.

use std::sync::OnceLock;
use wgpu::util::DeviceExt;

/// The device all tests of a process share.
///
/// # Panics
/// Without an adapter. `CROWD_NO_GPU=1` at compile time turns GPU tests into ignored ones.
pub fn device() -> &'static (wgpu::Device, wgpu::Queue) {
    static DEVICE: OnceLock<(wgpu::Device, wgpu::Queue)> = OnceLock::new();
    DEVICE.get_or_init(|| {
        let (device, queue, adapter) = crowd_stages::gpu::open_device()
            .expect("GPU tests need an adapter: install mesa-vulkan-drivers, or opt out aloud with CROWD_NO_GPU=1");
        println!("adapter: {} ({:?}, {})", adapter.name, adapter.backend, adapter.driver_info);
        (device, queue)
    })
}

/// A storage buffer with contents; one zeroed element when there are none.
pub fn storage<T: bytemuck::Pod>(contents: &[T]) -> wgpu::Buffer {
    let zeroed = [T::zeroed()];
    let contents = if contents.is_empty() { &zeroed } else { contents };
    filled(contents, wgpu::BufferUsages::STORAGE)
}

/// A storage buffer of `count` elements (at least one) for a stage to write.
pub fn output<T: bytemuck::Pod>(count: usize) -> wgpu::Buffer {
    storage(&vec![T::zeroed(); count])
}

/// A uniform.
pub fn uniform<T: bytemuck::Pod>(contents: &T) -> wgpu::Buffer {
    filled(std::slice::from_ref(contents), wgpu::BufferUsages::UNIFORM)
}

/// Arguments of an indirect dispatch.
pub fn indirect<T: bytemuck::Pod>(contents: &T) -> wgpu::Buffer {
    filled(std::slice::from_ref(contents), wgpu::BufferUsages::INDIRECT)
}

fn filled<T: bytemuck::Pod>(contents: &[T], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device().0.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(contents),
        usage: usage | wgpu::BufferUsages::COPY_SRC,
    })
}

/// Records one compute pass and submits it.
pub fn run(record: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
    let (device, queue) = device();
    let mut encoder = device.create_command_encoder(&Default::default());
    record(&mut encoder.begin_compute_pass(&Default::default()));
    queue.submit([encoder.finish()]);
}

/// The first `count` elements of a buffer, after everything submitted so far.
pub fn read<T: bytemuck::Pod>(buffer: &wgpu::Buffer, count: usize) -> Vec<T> {
    if count == 0 {
        return Vec::new();
    }
    let (device, queue) = device();
    let size = (count * size_of::<T>()) as u64;
    let back = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &back, 0, size);
    queue.submit([encoder.finish()]);
    let (sender, mapped) = std::sync::mpsc::channel();
    back.map_async(wgpu::MapMode::Read, .., move |result| sender.send(result).expect("the receiver waits below"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is not lost");
    // Another test's thread may be the one that polled this to its end: wait for word, not only for the device.
    mapped.recv().expect("the callback is called once").expect("a fresh buffer can be mapped");
    bytemuck::pod_collect_to_vec(&back.get_mapped_range(..).expect("just mapped"))
}

/// A colour target and what was drawn into it.
pub struct Picture {
    texture: wgpu::Texture,
    /// To draw into.
    pub view: wgpu::TextureView,
    /// Pixels.
    pub size: (u32, u32),
}

impl Picture {
    /// Of pictures made here.
    pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

    /// A black picture. The width must be a multiple of 64, so that rows can be copied as they are.
    pub fn new(size: (u32, u32)) -> Self {
        assert_eq!(size.0 % 64, 0, "rows are copied without padding");
        let texture = device().0.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Self::FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        Self { texture, view, size }
    }

    /// sRGB-encoded pixels, row 0 at the top.
    pub fn pixels(&self) -> Vec<[u8; 4]> {
        let (device, queue) = device();
        let count = self.size.0 as usize * self.size.1 as usize;
        let buffer = output::<u32>(count);
        let back = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: buffer.size(),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &back,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.size.0 * 4),
                    rows_per_image: None,
                },
            },
            self.texture.size(),
        );
        queue.submit([encoder.finish()]);
        read(&back, count)
    }
}
