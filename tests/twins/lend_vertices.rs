//! `lend_vertices` on the GPU against its twins: equal.

use crate::cases::{Case, buckets, case, cases, first_difference, impostored};
use crate::gather_drawn::{Sorted, on_cpu as drawn_of, sorted};
use crowd_stages::{DrawnInstance, LodChoice, Weight, cpu, gpu::LendVertices};
use crowd_tests::gpu;

/// A crowd with skinned vertices and casters of coarser levels.
struct Lent {
    case: Case,
    crowd: Sorted,
    drawn: Vec<DrawnInstance>,
    casters: Sorted,
    borrowers: Vec<DrawnInstance>,
}

fn lent(case: Case) -> Lent {
    let crowd = sorted(&case, case.count() * 20);
    let drawn = drawn_of(&case, &crowd);
    // Everyone but each seventh casts, with at most twelve vertices, whoever is seen.
    let caster = |i: usize| LodChoice { vertex_count: if i.is_multiple_of(7) { 0 } else { 12 }, triangle_count: 0 };
    let choices: Vec<LodChoice> = (0..case.instances.len()).map(caster).collect();
    let (culled, fill) = (vec![Default::default(); choices.len()], Default::default());
    let (keys, morphs) = cpu::key_instances(buckets(), &case.instances, &culled, &choices, &fill, &case.config);
    let (keys, values) = cpu::sort_instances(&keys);
    let (ranges, ..) = cpu::write_bucket_args(buckets(), &keys, &Default::default(), &case.config);
    let places = vec![Default::default(); ranges.len() + 1];
    let casters = Sorted { keys, values, morphs, ranges, places };
    let borrowers = drawn_of(&case, &casters);
    Lent { case, crowd, drawn, casters, borrowers }
}

impl Lent {
    fn on_gpu(&self) -> (Vec<u32>, Vec<DrawnInstance>) {
        let device = &gpu::device().0;
        let stage = LendVertices::new(device);
        let lent = gpu::output::<u32>(self.case.instances.len());
        let padded = |drawn: &[DrawnInstance]| {
            let mut all = drawn.to_vec();
            all.resize(self.case.instances.len(), DrawnInstance::default());
            gpu::storage(&all)
        };
        let (drawn, borrowers) = (padded(&self.drawn), padded(&self.borrowers));
        let bind = |sorted: &Sorted, drawn: &wgpu::Buffer| {
            let (keys, values) = (gpu::storage(&sorted.keys), gpu::storage(&sorted.values));
            let (config, counts) = (gpu::uniform(&self.case.config), gpu::uniform(&buckets().counts()));
            stage.bind(device, &config, &counts, &keys, &values, drawn, &lent)
        };
        let (lend, borrow) = (bind(&self.crowd, &drawn), bind(&self.casters, &borrowers));
        let count = self.case.count();
        gpu::run(|pass| stage.record_lend(pass, &lend, count));
        gpu::run(|pass| stage.record_borrow(pass, &borrow, count));
        (gpu::read(&lent, self.case.instances.len()), gpu::read(&borrowers, self.borrowers.len()))
    }

    fn on_cpu(&self) -> (Vec<u32>, Vec<DrawnInstance>) {
        let Self { crowd, drawn, casters, borrowers, .. } = self;
        let lent = cpu::lend_vertices(buckets(), &crowd.keys, &crowd.values, drawn);
        let borrowed = cpu::borrow_vertices(buckets(), &casters.keys, &casters.values, &lent, borrowers);
        (lent, borrowed)
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn lent_and_borrowed_vertices_agree_for_all_sizes() {
    for case in cases().chain(cases().map(impostored)).filter(|case| case.count() > 0) {
        let of = lent(case);
        let ((gpu, gpu_borrowed), (cpu, cpu_borrowed)) = (of.on_gpu(), of.on_cpu());
        assert_eq!(first_difference(&gpu, &cpu), None, "{} instances", of.case.count());
        assert_eq!(first_difference(&gpu_borrowed, &cpu_borrowed), None, "{} instances", of.case.count());
    }
}

#[test]
fn whoever_is_drawn_lends_its_own_vertices_and_one_of_somebody_else_is_seen() {
    let of = lent(case(1000, 30, Weight::Area));
    let (lent, borrowed) = of.on_cpu();
    let mut bases: Vec<u32> = lent.iter().copied().filter(|base| *base != crowd_pack::NONE).collect();
    assert!(bases.len() > 100 && bases.len() < 1000, "{} of 1000 lend", bases.len());
    bases.sort_unstable();
    assert!(bases.windows(2).all(|pair| pair[0] < pair[1]), "no two have the same vertices");
    for (entry, (key, i)) in of.casters.keys.iter().zip(&of.casters.values).enumerate().take(borrowed.len()) {
        assert!(*key < buckets().nobody());
        if *key < buckets().mesh_count {
            assert_eq!(borrowed[entry].vertex_base, lent[*i as usize], "caster {entry}");
        }
    }
    let mut swapped = borrowed.clone();
    swapped[3].vertex_base ^= 1;
    assert!(first_difference(&swapped, &borrowed).is_some());
}
