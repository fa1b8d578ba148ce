//! `play_motion` on the GPU against its twin: the same clips, where they are within a bound; and refusals.

use crate::cases::{Case, case, cases, data};
use crate::whole_chain::{OPTIONS, compare, draw, is_rounding, one_clip_each, renderer};
use crowd_pack::NONE;
use crowd_stages::gpu::{MotionPlan, PlayMotion};
use crowd_stages::{
    DrawOptions, InstanceRecord, MotionRecord, MotionSchedule, MotionStretch, Skinning, Technique, Weight, cpu,
};
use crowd_tests::gpu::{self, Picture};
use crowd_tests::synthetic::hash;

/// Schedules of each character's two clips, and who goes by which.
struct Plan {
    stretches: Vec<MotionStretch>,
    schedules: Vec<MotionSchedule>,
    motions: Vec<MotionRecord>,
}

/// A schedule a character, to and fro between its clips in one to twelve stretches; every seventh instance goes by none.
fn plan(instances: &[InstanceRecord]) -> Plan {
    let (mut stretches, mut schedules) = (Vec::new(), Vec::new());
    for (number, character) in (0..).zip(&data().characters) {
        let first = stretches.len() as u32;
        let count = 1 + number * 5;
        let mut start_s = 0.0;
        for i in 0..count {
            let stay_s = 1.0 + 0.3 * (hash(i + number) % 5) as f32;
            let clip = |i: u32| character.clip_offset + i % character.clip_count;
            stretches.push(MotionStretch {
                start_s,
                fade_s: 0.2 * (i % 4) as f32,
                clip: clip(i),
                turns: 0.3 * i as f32,
                first_rate_hz: 1.1,
                rate_hz: 0.7,
                left_clip: clip(i + 1),
                left_turns: 0.1 * i as f32,
                left_rate_hz: 0.7,
                left_last_rate_hz: 1.1,
                ..Default::default()
            });
            start_s += stay_s;
        }
        schedules.push(MotionSchedule { first, count, loop_s: start_s, reserved: 0 });
    }
    let motion = |(i, instance): (u32, &InstanceRecord)| MotionRecord {
        schedule: if i % 7 == 3 { NONE } else { instance.character },
        ahead_s: (hash(i) % 1000) as f32 * 0.02,
    };
    Plan { stretches, schedules, motions: (0..).zip(instances).map(motion).collect() }
}

impl Plan {
    fn on_cpu(&self, case: &Case) -> Vec<InstanceRecord> {
        let mut instances = case.instances.clone();
        let Self { stretches, schedules, motions } = self;
        cpu::play_motion(&data().clips, stretches, schedules, motions, case.config.time_s, &mut instances);
        instances
    }

    fn on_gpu(&self, case: &Case) -> Vec<InstanceRecord> {
        let stage = PlayMotion::new(&gpu::device().0);
        let instances = gpu::storage(&case.instances);
        let bound = stage.bind(
            &gpu::device().0,
            &gpu::uniform(&case.config),
            &gpu::storage(&self.motions),
            &gpu::storage(&self.schedules),
            &gpu::storage(&self.stretches),
            &gpu::storage(&data().clips),
            &instances,
        );
        gpu::run(|pass| stage.record(pass, &bound, case.count()));
        gpu::read(&instances, case.instances.len())
    }

    /// Whether a border of two stretches, or the end of the loop, is so near that rounding decides.
    fn is_borderline(&self, case: &Case, i: usize) -> bool {
        let motion = self.motions[i];
        let schedule = self.schedules[motion.schedule as usize];
        let within_s = (case.config.time_s + motion.ahead_s).rem_euclid(schedule.loop_s);
        let of_schedule = &self.stretches[schedule.first as usize..(schedule.first + schedule.count) as usize];
        let borders = of_schedule.iter().map(|one| one.start_s).chain([schedule.loop_s]);
        borders.into_iter().any(|border_s| (border_s - within_s).abs() < 1e-4)
    }
}

/// Turns of a clip by now, compared around the circle.
fn turns_agree(a: (u32, f32), b: (u32, f32), time_s: f32) -> bool {
    let turns = |(clip, phase_s): (u32, f32)| (time_s + phase_s) / data().clips[clip as usize].duration_s;
    let apart = (turns(a) - turns(b)).rem_euclid(1.0);
    a.0 == b.0 && apart.min(1.0 - apart) <= cpu::TURNS_BOUND
}

fn first_apart(case: &Case, plan: &Plan, gpu: &[InstanceRecord], cpu: &[InstanceRecord]) -> Option<String> {
    let time_s = case.config.time_s;
    let agree = |i: usize| {
        let (a, b) = (&gpu[i], &cpu[i]);
        if plan.motions[i].schedule == NONE {
            return a == b;
        }
        let place = |one: &InstanceRecord| (one.position, one.yaw_rad, one.scale, one.character);
        let own = turns_agree((a.clip, a.phase_s), (b.clip, b.phase_s), time_s);
        let left = turns_agree((a.leaving_clip, a.leaving_phase_s), (b.leaving_clip, b.leaving_phase_s), time_s);
        let share = (a.leaving_share - b.leaving_share).abs() <= cpu::SHARE_BOUND;
        place(a) == place(b) && ((own && left && share) || plan.is_borderline(case, i))
    };
    let i = (0..cpu.len()).find(|&i| !agree(i))?;
    Some(format!("instance {i}: {:?} on the GPU, {:?} on the CPU", gpu[i], cpu[i]))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn clips_agree_for_all_sizes_and_times() {
    for mut case in cases() {
        for time_s in [0.0, 1.3, 77.7] {
            case.config.time_s = time_s;
            let plan = plan(&case.instances);
            let (gpu, cpu) = (plan.on_gpu(&case), plan.on_cpu(&case));
            assert_eq!(first_apart(&case, &plan, &gpu, &cpu), None, "{} instances at {time_s} s", case.count());
        }
    }
}

#[test]
fn what_differs_is_seen_and_everyone_is_somewhere_in_a_fade() {
    let case = case(1000, 30, Weight::Area);
    let plan = plan(&case.instances);
    let expected = plan.on_cpu(&case);
    data().check_instances(&expected).expect("clips of their characters, shares from 0 to 1");
    let shares = |low: f32, high: f32| expected.iter().filter(|one| (low..=high).contains(&one.leaving_share)).count();
    assert!(shares(0.0, 0.0) > 300 && shares(0.1, 0.9) > 50, "{} {}", shares(0.0, 0.0), shares(0.1, 0.9));
    let one = (0..1000).find(|&i| plan.motions[i].schedule != NONE && !plan.is_borderline(&case, i)).expect("many");
    let with = |change: fn(&mut InstanceRecord)| {
        let mut changed = expected.clone();
        change(&mut changed[one]);
        first_apart(&case, &plan, &changed, &expected).is_some()
    };
    assert!(with(|one| one.clip += 1) && with(|one| one.phase_s += 0.01) && with(|one| one.leaving_share += 0.01));
    assert!(with(|one| one.position[0] += 0.01) && !with(|_| {}));
}

/// The picture of a crowd that goes by schedules is that of instances to which the twin gave their clips, however it is skinned.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_crowd_that_goes_by_schedules_is_drawn_as_the_twin_has_it() {
    let case = case(300, 200, Weight::Area);
    let plan = plan(&case.instances);
    let (device, queue) = gpu::device();
    let picture = Picture::new((640, 360));
    let of = |skinning| DrawOptions { skinning, ..DrawOptions::from(Technique::Bucketed) };
    let mut still = renderer(OPTIONS, &plan.on_cpu(&case));
    draw(&mut still, &picture, &case.config, of(Skinning::Vertex));
    let expected = picture.pixels();
    let mut moving = renderer(OPTIONS, &case.instances);
    draw(&mut moving, &picture, &case.config, of(Skinning::Vertex));
    assert!(compare(&picture.pixels(), &expected).share_over(8) > 0.01, "they do something else");
    let Plan { stretches, schedules, motions } = &plan;
    moving.set_motion(device, queue, Some(MotionPlan { stretches, schedules, motions })).expect("it can be followed");
    let mut of_vertex_shader = None;
    for skinning in Skinning::WAYS {
        draw(&mut moving, &picture, &case.config, of(skinning));
        let pixels = picture.pixels();
        let apart = compare(&pixels, &expected).share_over(8);
        assert!(apart < 1e-3, "{skinning:?}: {apart} of the pixels");
        assert!(is_rounding(&compare(&pixels, of_vertex_shader.get_or_insert(pixels.clone()))), "{skinning:?}");
    }
}

/// Only a stretch with a fade makes people fade.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn schedules_without_fades_leave_auto_its_choice() {
    let instances = one_clip_each(&case(10, 30, Weight::Area).instances);
    let (device, queue) = gpu::device();
    let mut renderer = renderer(OPTIONS, &instances);
    let mut plan = plan(&instances);
    let fades: Vec<f32> = plan.stretches.iter().map(|stretch| stretch.fade_s).collect();
    assert!(fades.iter().any(|fade_s| *fade_s > 0.0));
    for fade in [false, true] {
        plan.stretches.iter_mut().zip(&fades).for_each(|(one, fade_s)| one.fade_s = if fade { *fade_s } else { 0.0 });
        let Plan { stretches, schedules, motions } = &plan;
        renderer.set_motion(device, queue, Some(MotionPlan { stretches, schedules, motions })).expect("as before");
        let choice = renderer.skinning(Skinning::Auto);
        assert_eq!((choice.fades, choice.is_settled), (fade, fade), "{choice:?}");
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn what_could_not_be_followed_is_refused() {
    let case = case(10, 30, Weight::Area);
    let (device, queue) = gpu::device();
    let mut renderer = renderer(OPTIONS, &case.instances);
    let changes: [(&str, fn(&mut Plan)); 10] = [
        ("motion 1", |plan| plan.motions[1].schedule = 3),
        ("motion 0", |plan| plan.motions[0].ahead_s = f32::NAN),
        ("schedule 2", |plan| plan.schedules[2].count += 1),
        ("schedule 0", |plan| plan.schedules[0].count = 0),
        ("schedule 1", |plan| plan.schedules[1].loop_s = 0.0),
        ("schedule 1", |plan| plan.stretches[3].start_s = 99.0),
        ("stretch 4", |plan| plan.stretches[4].left_clip = 99),
        ("stretch 4", |plan| plan.stretches[4].fade_s = -1.0),
        ("stretch 0", |plan| plan.motions.iter_mut().for_each(|motion| motion.schedule = 0)),
        ("motions", |plan| plan.motions.push(plan.motions[0])),
    ];
    for (words, change) in changes {
        let mut plan = plan(&case.instances);
        change(&mut plan);
        let Plan { stretches, schedules, motions } = &plan;
        let refused = renderer.set_motion(device, queue, Some(MotionPlan { stretches, schedules, motions }));
        let error = refused.expect_err(words).to_string();
        assert!(error.starts_with(words), "{words}: {error}");
    }
    // Schedules end with those who went by them.
    let plan = plan(&case.instances);
    let Plan { stretches, schedules, motions } = &plan;
    renderer.set_motion(device, queue, Some(MotionPlan { stretches, schedules, motions })).expect("it can be followed");
    let bytes = renderer.gpu_bytes();
    renderer.set_instances(queue, &case.instances).expect("the same people");
    assert_eq!(renderer.gpu_bytes(), bytes);
    renderer.set_instances(queue, &case.instances[..9]).expect("fewer");
    assert!(renderer.gpu_bytes() < bytes);
    renderer.set_motion(device, queue, None).expect("nothing is always possible");
}
