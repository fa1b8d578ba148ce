//! Most memory that a simplification of 100,000 triangles over 500 frames holds, the mesh and its poses included.
//!
//! `cargo bench -p crowd-lod --bench peak_memory`: runs itself once for each choice of frames, so that one run's memory is
//! not counted with the next one's. Linux only: the kernel counts the peak.

mod snake;

use crowd_lod::{
    CollapseOrder, FrameChoice, LevelSurface, LodOptions, LodPoses, Surface, SurfaceError, measure_surfaces,
    measured_frames, reform, simplify,
};
use snake::{Snake, Waves};
use std::time::Instant;

const CHOICES: [(&str, FrameChoice); 3] =
    [("auto", FrameChoice::Auto), ("all", FrameChoice::All), ("bind", FrameChoice::Bind)];

fn main() {
    let asked = std::env::args().find_map(|word| word.strip_prefix("frames=").map(str::to_owned));
    let Some(asked) = asked else {
        let program = std::env::current_exe().expect("the system knows what runs");
        for (name, _) in CHOICES {
            let run = std::process::Command::new(&program).arg(format!("frames={name}")).status();
            assert!(run.expect("the program can be run again").success(), "--frames {name} failed");
        }
        return;
    };
    let (_, frames) = *CHOICES.iter().find(|(name, _)| *name == asked).expect("one of the choices");
    let (snake, waves) = (Snake::new(200, 250), Waves::new(5, 100));
    let before = peak_kib();
    let started = Instant::now();
    let options = LodOptions { frames, ..LodOptions::default() };
    let order = simplify(&snake.mesh(), &waves.poses(), &options, &|_| ()).expect("the snake is a valid mesh");
    let seconds = started.elapsed().as_secs_f64();
    println!(
        "--frames {asked}: {seconds:.2} s, peak {} MB ({} MB before it began), {} of {} frames, down to {} triangles, \
         map {:016x}",
        peak_kib() / 1024,
        before / 1024,
        order.frames.used,
        order.frames.given,
        order.levels[0].triangle_count,
        fingerprint(&order.collapse_map),
    );
    for (triangle_count, error) in measure(&snake, &waves, &order) {
        println!("  {triangle_count} triangles: {:.3} mm RMS, {:.2} mm at most", error.rms_m * 1e3, error.max_m * 1e3);
    }
    if let Some(check) = order.frames.check {
        println!("  check: {check:?}, {} rerun(s)", order.frames.rerun_count);
    }
}

/// Five levels as a bake measures them: triangles left and errors.
fn measure(snake: &Snake, waves: &Waves, order: &CollapseOrder) -> Vec<(u32, SurfaceError)> {
    let chosen = [0.5, 0.25, 0.1, 0.05, 0.02].map(|share| {
        let wanted = (share * snake.triangles.len() as f64) as u32;
        *order.levels.iter().rfind(|level| level.triangle_count <= wanted).expect("a level so small")
    });
    let levels =
        chosen.map(|level| reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count));
    let at = |v: &u32| *v as usize;
    let full = Surface {
        positions: &order.vertex_source.iter().map(at).map(|v| snake.positions[v]).collect::<Vec<_>>(),
        normals: &order.normal_source.iter().map(at).map(|v| snake.normals[v]).collect::<Vec<_>>(),
        uvs: &order.attribute_source.iter().map(at).map(|v| snake.uvs[v]).collect::<Vec<_>>(),
        joints: &order.vertex_source.iter().map(at).map(|v| snake.joints[v]).collect::<Vec<_>>(),
        weights: &order.vertex_source.iter().map(at).map(|v| snake.weights[v]).collect::<Vec<_>>(),
        triangles: &order.triangles,
    };
    let poses = waves.poses();
    let frames = measured_frames(poses.frame_weights, 8);
    let palette = |&frame: &usize| &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
    let palettes: Vec<_> = frames.iter().flat_map(palette).copied().collect();
    let poses =
        LodPoses { palettes: &palettes, joint_count: poses.joint_count, frame_weights: &vec![0.125; frames.len()] };
    let surfaces = levels.each_ref().map(|level| LevelSurface::Shared(level));
    let texels = vec![[0.0; 2]; full.positions.len()];
    let errors = measure_surfaces(&full, &texels, &surfaces, &poses, frames.len(), 1000);
    chosen.iter().map(|level| level.triangle_count).zip(errors).collect()
}

/// FNV-1a: tells at a glance whether two runs gave the same.
fn fingerprint(numbers: &[u32]) -> u64 {
    let bytes = numbers.iter().flat_map(|number| number.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The most memory this process held so far, KiB.
fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux tells of its processes");
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).expect("the kernel counts the peak");
    let number: String = line.chars().filter(char::is_ascii_digit).collect();
    number.parse().expect("digits")
}
