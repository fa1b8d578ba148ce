//! GPU memory: the largest budget that fits so many bytes, or a table of what takes how much.

use crate::crowd::Crowd;
use crate::gpu_backend::canvas_bytes;
use crate::gpu_device::Gpu;
use crate::plan::DetailPlan;
use crate::{Error, Result};
use crowd_pack::LodRecord;
use crowd_stages::gpu::{CrowdRenderer, MemoryUse, RendererOptions, most_instances};
use crowd_stages::{BudgetIn, CrowdData, DrawOptions, InstanceRecord, Technique};

/// Bytes of a megabyte, as `--vram` counts them.
pub const MEGABYTE: u64 = 1 << 20;

/// Parts of the memory by name, bytes.
pub type Parts = Vec<(&'static str, u64)>;

/// Upper bounds of what frames of a crowd may select.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrowdNeeds {
    instances: u32,
    /// Everyone at full detail: vertices, triangles.
    full: [u64; 2],
    /// Everyone at their coarsest mesh.
    least: [u64; 2],
    /// The most triangles a vertex, and vertices a triangle, of any level.
    ratios: [f64; 2],
    budget_in: BudgetIn,
}

impl CrowdNeeds {
    /// Adds everyone up.
    pub fn of(data: &CrowdData, instances: &[InstanceRecord], budget_in: BudgetIn) -> Self {
        let (mut full, mut least) = ([0u64; 2], [0u64; 2]);
        for one in instances {
            let character = &data.characters[one.character as usize];
            full[0] += u64::from(character.vertex_count);
            full[1] += u64::from(character.triangle_count);
            least[0] += u64::from(character.min_vertex_count);
            least[1] += u64::from(character.min_triangle_count);
        }
        let largest = |ratio: fn(&LodRecord) -> f64| {
            let levels = data.lods.iter().filter(|lod| lod.vertex_count > 0 && lod.triangle_count > 0);
            levels.map(ratio).fold(1.0, f64::max)
        };
        let ratios = [
            largest(|lod| f64::from(lod.triangle_count) / f64::from(lod.vertex_count)),
            largest(|lod| f64::from(lod.vertex_count) / f64::from(lod.triangle_count)),
        ];
        Self { instances: instances.len() as u32, full, least, ratios, budget_in }
    }

    /// Vertices and triangles that a frame of that budget may select at most; the coarsest levels are drawn whatever the budget.
    pub fn at(&self, budget: u32) -> [u64; 2] {
        let counted = self.budget_in as usize;
        let other = 1 - counted;
        let counts = u64::from(budget).max(self.least[counted]).min(self.full[counted]);
        // One more an instance for the rounding.
        let others = (counts as f64 * self.ratios[counted]) as u64 + u64::from(self.instances);
        let mut needs = [0; 2];
        (needs[counted], needs[other]) = (counts, others.min(self.full[other]));
        needs
    }

    /// The budget that nobody needs more than.
    fn most(&self) -> u32 {
        u32::try_from(self.full[self.budget_in as usize]).unwrap_or(u32::MAX).max(1)
    }

    /// The least budget that has room of its own.
    fn least(&self) -> u32 {
        u32::try_from(self.least[self.budget_in as usize]).unwrap_or(u32::MAX).max(1)
    }

    /// Sizes that hold every frame of that budget, as far as the adapter allows.
    pub fn options(
        &self,
        device: &wgpu::Device,
        color_format: wgpu::TextureFormat,
        sample_count: u32,
        budget: u32,
    ) -> RendererOptions {
        let [max_vertices, max_triangles] =
            self.at(budget).map(|count| u32::try_from(count).unwrap_or(u32::MAX).max(1));
        let max_instances = self.instances;
        let options = RendererOptions {
            max_instances,
            max_vertices,
            max_triangles,
            color_format,
            sample_count,
            ..RendererOptions::default()
        };
        options.clamped_to(&device.limits())
    }
}

/// Refuses more people than the device binds at a time.
///
/// # Errors
/// [`crowd_stages::Error::Limit`] with how many it can take.
pub fn check_count(device: &wgpu::Device, count: usize, draws: &[DrawOptions]) -> Result<()> {
    let limits = device.limits();
    let allowed = draws.iter().map(|draw| most_instances(&limits, draw)).min().unwrap_or(u32::MAX).into();
    let (what, needed) = ("people", count as u64);
    let remedy = "use --count, or a layout file, with no more than that";
    match needed > allowed {
        true => Err(crowd_stages::Error::Limit { what, needed, allowed, remedy }.into()),
        false => Ok(()),
    }
}

/// What is in GPU memory besides the renderer's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beside {
    /// Pictures of the frame's size that are there at a time (what is drawn into, screenshots, what the reference camera sees), each with
    /// what it is read back through.
    pub canvases: u64,
    /// Of a simulator, where there is one.
    pub simulator_bytes: Option<u64>,
}

impl Beside {
    /// All parts by name, for frames of that size.
    pub fn with(self, used: &MemoryUse, size: [u32; 2]) -> Parts {
        let picture = ("picture", self.canvases * canvas_bytes(size));
        let simulator = self.simulator_bytes.map(|bytes| ("simulator", bytes));
        used.parts().into_iter().chain([picture]).chain(simulator).collect()
    }
}

/// Memory that a renderer may take, and for what.
#[derive(Debug, Clone)]
pub struct Room {
    /// Bytes.
    limit_bytes: u64,
    beside: Beside,
    /// What is drawn, in turn or one after another.
    draws: Vec<DrawOptions>,
    needs: CrowdNeeds,
    /// Of the pictures.
    color_format: wgpu::TextureFormat,
    samples: u32,
}

impl Room {
    /// `detail`: whose budget is counted, and with which techniques; `draws`: those that are drawn.
    pub fn new(
        limit_bytes: u64,
        crowd: &Crowd,
        detail: &DetailPlan,
        draws: Vec<DrawOptions>,
        beside: Beside,
        (color_format, samples): (wgpu::TextureFormat, u32),
    ) -> Self {
        let needs = CrowdNeeds::of(&crowd.data, &crowd.instances, detail.budget_in);
        Self { limit_bytes, beside, draws, needs, color_format, samples }
    }

    fn options(&self, gpu: &Gpu, budget: u32) -> RendererOptions {
        self.needs.options(&gpu.device, self.color_format, self.samples, budget)
    }

    fn foretell(&self, gpu: &Gpu, renderer: &CrowdRenderer, size: [u32; 2], budget: u32) -> MemoryUse {
        renderer.memory_of(self.options(gpu, budget), &self.draws, (size[0], size[1]))
    }

    fn parts(&self, gpu: &Gpu, renderer: &CrowdRenderer, size: [u32; 2], budget: u32) -> Parts {
        self.beside.with(&self.foretell(gpu, renderer, size, budget), size)
    }

    /// Whether frames of that budget fit.
    fn holds(&self, gpu: &Gpu, renderer: &CrowdRenderer, size: [u32; 2], budget: u32) -> bool {
        self.parts(gpu, renderer, size, budget).iter().map(|(_, bytes)| bytes).sum::<u64>() <= self.limit_bytes
    }

    /// Makes room for the largest budget that fits, or for `budget`, if given; that budget.
    ///
    /// # Errors
    /// [`Error::Memory`] with what takes how much, when that budget, or the least, does not fit.
    pub fn fit(&self, gpu: &Gpu, renderer: &mut CrowdRenderer, size: [u32; 2], budget: Option<u32>) -> Result<u32> {
        let least = budget.unwrap_or_else(|| self.needs.least());
        if !self.holds(gpu, renderer, size, least) {
            let parts = self.parts(gpu, renderer, size, least);
            let (limit_bytes, budget_in) = (self.limit_bytes, self.needs.budget_in.name());
            return Err(Error::Memory { limit_bytes, budget: least, budget_in, table: table(&parts) });
        }
        let found = budget.unwrap_or_else(|| self.largest(gpu, renderer, size, least));
        let RendererOptions { max_vertices, max_triangles, .. } = self.options(gpu, found);
        renderer.make_room(max_vertices, max_triangles);
        Ok(found)
    }

    /// Why N is no larger though memory is left, where it is so.
    pub fn remark(&self, gpu: &Gpu, renderer: &CrowdRenderer, size: [u32; 2], found: u32) -> Option<String> {
        let more = found.saturating_add(found / 100).saturating_add(1);
        if more > self.needs.most() || !self.holds(gpu, renderer, size, more) {
            return None;
        }
        let binding = gpu.device.limits().max_storage_buffer_binding_size / MEGABYTE;
        let reforms = self.draws.iter().any(|draw| draw.technique == Technique::Reform);
        let remedy = if reforms { "; other techniques than reform need no list of all triangles" } else { "" };
        Some(format!("N is limited by the adapter's buffers of {binding} MiB, not by --vram{remedy}"))
    }

    fn largest(&self, gpu: &Gpu, renderer: &CrowdRenderer, size: [u32; 2], least: u32) -> u32 {
        // Reformation writes whole lists of what it draws: beyond what the adapter binds people would be missing.
        let reforms = self.draws.iter().any(|draw| draw.technique == Technique::Reform);
        let fits = |budget: u32| {
            let RendererOptions { max_vertices, max_triangles, .. } = self.options(gpu, budget);
            let [vertices, triangles] = self.needs.at(budget);
            let is_whole = vertices <= max_vertices.into() && triangles <= max_triangles.into();
            (is_whole || !reforms) && self.holds(gpu, renderer, size, budget)
        };
        let (mut low, mut high) = (least, self.needs.most().max(least));
        while low < high {
            let middle = low + (high - low).div_ceil(2);
            if fits(middle) {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        low
    }

    /// Whether what is drawn fits in pictures of that size, too.
    pub fn holds_size(&self, gpu: &Gpu, renderer: &CrowdRenderer, size: [u32; 2], budget: u32) -> bool {
        self.holds(gpu, renderer, size, budget)
    }

    /// Takes note that something else is drawn from now on; `false` where that does not fit beside what was drawn before.
    pub fn admit(
        &mut self,
        gpu: &Gpu,
        renderer: &CrowdRenderer,
        size: [u32; 2],
        budget: u32,
        draw: DrawOptions,
    ) -> bool {
        if self.draws.contains(&draw) {
            return true;
        }
        self.draws.push(draw);
        let fits = self.holds(gpu, renderer, size, budget);
        if !fits {
            self.draws.pop();
        }
        fits
    }
}

/// The largest part first, megabytes; what takes nothing is left out.
pub fn table(parts: &[(&'static str, u64)]) -> String {
    let mut parts: Parts = parts.iter().copied().filter(|(_, bytes)| *bytes > 0).collect();
    parts.sort_by_key(|(name, bytes)| (std::cmp::Reverse(*bytes), *name));
    let total: u64 = parts.iter().map(|(_, bytes)| bytes).sum();
    let line = |(name, bytes): &(&str, u64)| format!("\n  {name:<12} {:>9.2} MB", *bytes as f64 / MEGABYTE as f64);
    parts.iter().chain([&("in all", total)]).map(line).collect()
}

/// What the draws of a bench need besides: its pictures are compared with those of the baseline.
pub fn with_baseline(mut draws: Vec<DrawOptions>) -> Vec<DrawOptions> {
    draws.push(Technique::PseudoInstancing.into());
    draws
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_pack::CharacterRecord;

    fn needs(budget_in: BudgetIn) -> CrowdNeeds {
        let lod = |vertex_count, triangle_count| LodRecord { vertex_count, triangle_count };
        let character = CharacterRecord {
            vertex_count: 100,
            triangle_count: 150,
            min_vertex_count: 10,
            min_triangle_count: 5,
            ..Default::default()
        };
        let data = CrowdData {
            characters: vec![character],
            lods: vec![lod(0, 0), lod(10, 18), lod(100, 150)],
            ..Default::default()
        };
        CrowdNeeds::of(&data, &vec![InstanceRecord::default(); 10], budget_in)
    }

    #[test]
    fn room_for_every_frame() {
        let of = needs(BudgetIn::Vertices);
        assert_eq!(of.at(5_000), [1000, 1500]);
        assert_eq!(of.at(200), [200, 370]);
        assert_eq!(of.at(1)[0], 100, "the coarsest levels are drawn whatever the budget");
        let of = needs(BudgetIn::Triangles);
        assert_eq!(of.at(5_000), [1000, 1500]);
        assert_eq!(of.at(200), [210, 200]);
        assert_eq!(of.at(1)[1], 50);
    }

    #[test]
    fn the_table_has_the_largest_first_and_the_sum_last() {
        let text = table(&[("images", 3 << 20), ("shadows", 0), ("characters", 5 << 20)]);
        let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
        assert!(lines[0].contains("characters") && lines[0].ends_with("5.00 MB"), "{text}");
        assert!(lines.len() == 3 && lines[2].contains("in all") && lines[2].contains("8.00 MB"), "{text}");
    }
}
