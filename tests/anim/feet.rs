//! Feet of people who walk: how fast a standing foot moves over the ground, beside a clip that knows nothing of the ground.

use crowd_anim::{FootContact, Mat3x4, SampledClip, foot_contacts, ground_speed, sample_clip};
use crowd_scene::{Cast, Gait, GaitClip, Mover, RootPath, Walker};
use crowd_source::{Limits, RawCharacter, load_character};
use crowd_tests::folders::assets;
use crowdbake::views::{clip_view, joints_of, skeleton_of};
use glam::{Mat3, Vec3};
use std::path::{Path, PathBuf};

/// Times looked at in a turn of the clip.
const LOOKS: usize = 240;
/// At the ends of a contact feet come and go.
const MARGIN: f32 = 0.15;

struct Walk {
    raw: RawCharacter,
    clip: SampledClip,
    contacts: Vec<FootContact>,
    gait: GaitClip,
}

impl Walk {
    fn of(path: &Path, clip: &str) -> Self {
        let raw = load_character(path, &Limits::default()).expect("a good character");
        let (skeleton, joints) = (skeleton_of(&raw), joints_of(&raw));
        let named = raw.clips.iter().find(|one| one.name == clip).expect("the clip is there");
        let clip = sample_clip(&skeleton, &joints, &clip_view(named), 30.0).expect("a good clip");
        let mesh = &raw.mesh;
        let speed = ground_speed(&mesh.positions, &mesh.joints, &mesh.weights, &clip, joints.len());
        assert!(speed > 0.0, "{path:?} walks");
        let feet = foot_contacts(&mesh.positions, &mesh.joints, &mesh.weights, &clip, joints.len());
        let [x, _, z] = clip.root_motion.displacement_m;
        let gait = GaitClip {
            clip: 0,
            duration_s: clip.duration_s,
            ground_speed_m_s: speed,
            displacement_m: if (x * x + z * z).sqrt() > 0.05 { Vec3::new(x, 0.0, z) } else { Vec3::ZERO },
            root_path: RootPath::of(&feet.root_path_m),
        };
        Self { clip, contacts: feet.contacts, gait, raw }
    }

    /// Somebody who has walked for `time_s` at `speed` times the clip's own: the clip's time, and where each vertex is in the world.
    fn posed(&self, gait: GaitClip, speed: f32, time_s: f32) -> (f32, impl Fn(usize) -> Vec3) {
        let walked_m = self.gait.ground_speed_m_s * speed * time_s;
        let cast =
            Cast { movers: vec![Mover { clips: [gait; 3], scale: 1.0, run_ahead_turns: 0.0 }], seed: 0, fade_s: 0.0 };
        let walker = Walker {
            id: 0,
            position: Vec3::new(0.0, 0.0, walked_m),
            yaw_rad: 0.0,
            speed_m_s: self.gait.ground_speed_m_s * speed,
            gait: Gait::Walk,
            walked_m,
            ran_m: 0.0,
            gait_before: Gait::Walk,
            changed_s: f32::INFINITY,
        };
        let one = cast.instance(&walker, time_s);
        let clip_s = (time_s + one.phase_s).rem_euclid(self.clip.duration_s);
        let palette = self.palette(clip_s);
        let turn = Mat3::from_rotation_y(one.yaw_rad);
        (clip_s, move |vertex| one.position + turn * (self.skin(vertex, &palette) * one.scale))
    }

    /// The lowest point of each foot in the world; nothing for feet that do not stand.
    fn feet(&self, gait: GaitClip, speed: f32, time_s: f32) -> Vec<Option<(usize, Vec3)>> {
        let (clip_s, place) = self.posed(gait, speed, time_s);
        let stands = |contact: &FootContact| {
            let margin = MARGIN * (contact.end_s - contact.start_s);
            (contact.start_s + margin..contact.end_s - margin).contains(&clip_s)
        };
        let lowest = |contact: &FootContact| {
            let own = (0..self.raw.mesh.positions.len()).filter(|&v| self.leading(v) == contact.joint);
            own.map(|v| (v, place(v))).min_by(|a, b| a.1.y.total_cmp(&b.1.y)).filter(|_| stands(contact))
        };
        self.contacts.iter().map(lowest).collect()
    }

    fn leading(&self, vertex: usize) -> u32 {
        let (joints, weights) = (self.raw.mesh.joints[vertex], self.raw.mesh.weights[vertex]);
        u32::from(joints[(1..4).fold(0, |best, i| if weights[i] > weights[best] { i } else { best })])
    }

    fn palette(&self, clip_s: f32) -> Vec<Mat3x4> {
        let joints = self.raw.joints.len();
        let at = clip_s / self.clip.duration_s * (self.clip.frame_count - 1) as f32;
        let first = (at as usize).min(self.clip.frame_count as usize - 2);
        let share = at - first as f32;
        let frame = |f: usize| &self.clip.palettes[f * joints..(f + 1) * joints];
        let mix = |(a, b): (&Mat3x4, &Mat3x4)| {
            [0, 1, 2].map(|r: usize| [0, 1, 2, 3].map(|c: usize| a[r][c] + (b[r][c] - a[r][c]) * share))
        };
        frame(first).iter().zip(frame(first + 1)).map(mix).collect()
    }

    fn skin(&self, vertex: usize, palette: &[Mat3x4]) -> Vec3 {
        let [x, y, z] = self.raw.mesh.positions[vertex];
        let mut point = Vec3::ZERO;
        for (joint, weight) in self.raw.mesh.joints[vertex].iter().zip(self.raw.mesh.weights[vertex]) {
            let rows = palette[usize::from(*joint)];
            point += weight * Vec3::from(rows.map(|r| r[0] * x + r[1] * y + r[2] * z + r[3]));
        }
        point
    }

    /// Mean speed over the ground of the lowest points of feet that stand, metres a second. A point is followed for one look; the next may
    /// be another of the sole, which rolls.
    fn slide(&self, gait: GaitClip, speed: f32) -> f32 {
        let look_s = self.clip.duration_s / LOOKS as f32;
        let (mut sum, mut count) = (0.0, 0);
        for look in 0..LOOKS {
            let time_s = 10.0 + look as f32 * look_s;
            let after = self.feet(gait, speed, time_s + look_s * 0.25);
            for (a, b) in self.feet(gait, speed, time_s).into_iter().zip(after) {
                if let (Some((v, a)), Some((w, b))) = (a, b)
                    && v == w
                {
                    sum += ((b - a) * Vec3::new(1.0, 0.0, 1.0)).length() / (look_s * 0.25);
                    count += 1;
                }
            }
        }
        assert!(count > 8, "feet stand");
        sum / count as f32
    }

    /// Median speed over the ground of the body's lowest point, metres a second, by looks in which it is as low as it is half of the time:
    /// knows nothing of contacts or joints.
    fn lowest_slide(&self, gait: GaitClip, speed: f32) -> f32 {
        let look_s = self.clip.duration_s / LOOKS as f32;
        let mut steps: Vec<(f32, f32)> = Vec::new();
        for look in 0..LOOKS {
            let time_s = 10.0 + look as f32 * look_s;
            let (_, place) = self.posed(gait, speed, time_s);
            let (_, place_after) = self.posed(gait, speed, time_s + look_s * 0.25);
            let points = (0..self.raw.mesh.positions.len()).map(|vertex| (vertex, place(vertex)));
            let (vertex, before) = points.min_by(|a, b| a.1.y.total_cmp(&b.1.y)).expect("a body");
            let way = (place_after(vertex) - before) * Vec3::new(1.0, 0.0, 1.0);
            steps.push((before.y, way.length() / (look_s * 0.25)));
        }
        steps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut speeds: Vec<f32> = steps[..LOOKS / 2].iter().map(|step| step.1).collect();
        speeds.sort_unstable_by(f32::total_cmp);
        speeds[speeds.len() / 2]
    }

    /// Slides of standing feet, on the way and where the clip plays at its own rate, mean of a slow and a fast walker; metres a second.
    fn slides(&self) -> [f32; 3] {
        self.ways().map(|gait| 0.5 * (self.slide(gait, 0.5) + self.slide(gait, 2.0)))
    }

    /// The same of the lowest point, on the way and at the clip's own rate.
    fn lowest_slides(&self) -> [f32; 2] {
        let [rooted, _, unscaled] = self.ways();
        [rooted, unscaled].map(|gait| 0.5 * (self.lowest_slide(gait, 0.5) + self.lowest_slide(gait, 2.0)))
    }

    /// On the way, without the root's path, and at the clip's own rate.
    fn ways(&self) -> [GaitClip; 3] {
        let even = GaitClip { root_path: RootPath::default(), ..self.gait };
        let unscaled = GaitClip { ground_speed_m_s: 0.0, ..even };
        [self.gait, even, unscaled]
    }
}

fn cast(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/good").join(format!("{name}.glb"))
}

fn check(path: &Path, clip: &str, most: f32) -> Walk {
    let walk = Walk::of(path, clip);
    let [rooted, even, unscaled] = walk.slides();
    println!(
        "{} {clip}: walks at {:.2} m/s; standing feet move at {rooted:.3} m/s, {even:.3} without the root's path, {unscaled:.3} unscaled: {:.3}, {:.3}",
        path.file_stem().unwrap_or_default().display(),
        walk.gait.ground_speed_m_s,
        rooted / unscaled,
        even / unscaled,
    );
    assert!(rooted <= most * unscaled, "{path:?} {clip}: {rooted} of {unscaled} m/s");
    walk
}

#[test]
fn standing_feet_of_the_cast_stay() {
    for name in ["anselm", "mara", "oskar", "pip", "gnu", "zebra"] {
        for clip in ["walk", "run"] {
            let [rooted, unscaled] = check(&cast(name), clip, 0.1).lowest_slides();
            println!("  the lowest point of the body: {rooted:.3} of {unscaled:.3} m/s: {:.3}", rooted / unscaled);
            // The cast swings no foot through the ground (made by hand, some do), so what is lowest stands. It rolls from heel to toe.
            assert!(rooted <= 0.15 * unscaled, "{name} {clip}: {rooted} of {unscaled} m/s");
        }
    }
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn standing_feet_of_real_characters_stay() {
    let clips = [
        ("khronos-fox/Fox.glb", "Walk"),
        ("quaternius-ultimate-characters/Knight_Male.gltf", "Walk"),
        ("quaternius-ultimate-characters/Knight_Male.gltf", "Run"),
        ("kaykit-adventurers/Barbarian.glb", "Walking_A"),
        ("kaykit-adventurers/Barbarian.glb", "Running_A"),
        ("gdquest-gdbot/gdbot.glb", "walk"),
        ("gdquest-gdbot/gdbot.glb", "run"),
        ("quaternius-animals/Horse.glb", "AnimalArmature|Walk"),
    ];
    for (path, clip) in clips {
        check(&assets().join(path), clip, 0.15);
    }
}
