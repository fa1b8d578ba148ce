//! What the stages are run on, and how integers are compared.

use crowd_stages::{
    Buckets, Capacities, CrowdData, CullRecord, FrameConfig, InstanceRecord, LodChoice, Weight, WeightSums, cpu,
};
use crowd_tests::synthetic;
use std::fmt::Debug;
use std::sync::OnceLock;

/// None, one, around a group of 64, several blocks of 256, more blocks than a block has threads.
pub const SIZES: [u32; 7] = [0, 1, 63, 64, 65, 1000, 70_000];

/// A crowd in front of a camera.
pub struct Case {
    pub data: &'static CrowdData,
    pub instances: Vec<InstanceRecord>,
    pub config: FrameConfig,
}

/// The CPU's results up to the levels: what later stages are fed with.
pub struct Selected {
    pub culled: Vec<CullRecord>,
    pub sums: WeightSums,
    pub wanted: Vec<u32>,
    pub choices: Vec<LodChoice>,
}

/// Its buckets, made once.
pub fn buckets() -> &'static Buckets {
    static BUCKETS: OnceLock<Buckets> = OnceLock::new();
    BUCKETS.get_or_init(|| Buckets::of(data()).expect("the barrels have index tables"))
}

/// The synthetic crowd, made once.
pub fn data() -> &'static CrowdData {
    static DATA: OnceLock<CrowdData> = OnceLock::new();
    DATA.get_or_init(synthetic::crowd)
}

/// `budget_each`: vertices of the budget for each instance of the crowd, seen or not.
pub fn case(count: u32, budget_each: u32, weight: Weight) -> Case {
    let instances = synthetic::instances(data(), count);
    Case { data: data(), instances, config: synthetic::config(count, count * budget_each, weight) }
}

/// All sizes with a budget that is ample for far ones and tight for near ones.
pub fn cases() -> impl Iterator<Item = Case> {
    SIZES.into_iter().map(|count| case(count, 30, Weight::Area))
}

/// The same where everyone smaller on the screen than the middle one may be dots.
pub fn dotted(mut case: Case) -> Case {
    let culled = cpu::cull_instances(case.data, &case.instances, &case.config);
    let mut areas: Vec<f32> = culled.iter().filter(|cull| cull.visible != 0).map(|cull| cull.area_px2).collect();
    areas.sort_by(f32::total_cmp);
    case.config.dot_area_px2 = areas.get(areas.len() / 2).copied().unwrap_or(1.0);
    case
}

/// The same where those smaller than the middle one are their impostors, somewhat larger ones on the way there, and the smallest may be dots.
pub fn impostored(case: Case) -> Case {
    let mut case = dotted(case);
    case.config.impostor_area_px2 = case.config.dot_area_px2;
    case.config.dot_area_px2 *= 0.5;
    case
}

impl Case {
    pub fn count(&self) -> u32 {
        self.instances.len() as u32
    }

    /// Culled and summed alone, for weights that Eq. 1 does not know.
    pub fn select_culled(&self) -> Selected {
        let culled = cpu::cull_instances(self.data, &self.instances, &self.config);
        let sums = cpu::sum_weights(self.data, &self.instances, &culled, &self.config);
        Selected { culled, sums, wanted: Vec::new(), choices: Vec::new() }
    }

    pub fn select(&self) -> Selected {
        let culled = cpu::cull_instances(self.data, &self.instances, &self.config);
        let mut sums = cpu::sum_weights(self.data, &self.instances, &culled, &self.config);
        let wanted = cpu::select_lod(self.data, &self.instances, &culled, &sums, &self.config);
        let choices = cpu::fit_budget(self.data, &self.data.lods, &self.instances, &wanted, &mut sums, &self.config);
        Selected { culled, sums, wanted, choices }
    }
}

/// Room for all, and room for about half of what is needed.
pub fn ample_and_scarce(choices: &[LodChoice]) -> [Capacities; 2] {
    let (_, end) = cpu::scan_counts(choices);
    let capacities = |vertex_count, triangle_count| Capacities { vertex_count, triangle_count, ..Default::default() };
    [
        capacities(end.vertex_base.max(1), end.triangle_base.max(1)),
        capacities((end.vertex_base / 2).max(1), end.triangle_base.max(1)),
    ]
}

/// The first place where two slices are not equal, in words.
pub fn first_difference<T: PartialEq + Debug>(gpu: &[T], cpu: &[T]) -> Option<String> {
    if gpu.len() != cpu.len() {
        return Some(format!("{} on the GPU, {} on the CPU", gpu.len(), cpu.len()));
    }
    let place = gpu.iter().zip(cpu).position(|(gpu, cpu)| gpu != cpu)?;
    Some(format!("at {place}: {:?} on the GPU, {:?} on the CPU", gpu[place], cpu[place]))
}

/// Whether two numbers are within a share of the larger.
pub fn close(a: f32, b: f32, share: f32) -> bool {
    (a - b).abs() <= share * a.abs().max(b.abs())
}

#[test]
fn one_changed_value_or_length_is_seen() {
    assert_eq!(first_difference(&[1, 2, 3], &[1, 2, 3]), None);
    let changed = first_difference(&[1, 2, 3], &[1, 7, 3]).expect("differs");
    assert_eq!(changed, "at 1: 2 on the GPU, 7 on the CPU");
    assert!(first_difference(&[1, 2], &[1, 2, 3]).is_some());
    assert!(close(1.0, 1.000_001, 2e-6) && !close(1.0, 1.001, 1e-6) && !close(1.0, f32::NAN, 1.0));
}

#[test]
fn the_cases_are_worth_running() {
    let case = case(1000, 30, Weight::Area);
    let selected = case.select();
    let seen = selected.sums.visible_count;
    assert!((200..900).contains(&seen), "{seen} of 1000 seen: the frustum must cut the crowd");
    let levels: std::collections::BTreeSet<u32> = selected.choices.iter().map(|c| c.vertex_count).collect();
    assert!(levels.len() > 20, "{} levels: near and far must differ", levels.len());
}
