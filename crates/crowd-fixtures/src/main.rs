//! `crowd-fixtures DIR` rewrites the fixtures; `crowd-fixtures --preview DIR` draws contact sheets of the characters.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use crowd_fixtures::glb::Document;
use crowd_fixtures::{beast, generate, people, preview};
use glam::Vec3;

/// Draws the characters and proofs under fixtures/, the same bytes every time.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// Folder to write to (the repository's `fixtures`).
    folder: PathBuf,
    /// Draw contact sheets of the characters there instead.
    #[arg(long)]
    preview: bool,
    /// Only what is named so.
    #[arg(long)]
    only: Option<String>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let result = if args.preview { draw_sheets(&args) } else { write_all(&args) };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("crowd-fixtures: {}: {error}", args.folder.display());
            ExitCode::from(3)
        }
    }
}

fn write_all(args: &Args) -> std::io::Result<()> {
    for fixture in generate() {
        let path = args.folder.join(&fixture.path);
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
        std::fs::write(&path, &fixture.bytes)?;
        println!("{} {} bytes", fixture.path, fixture.bytes.len());
    }
    Ok(())
}

fn draw_sheets(args: &Args) -> std::io::Result<()> {
    std::fs::create_dir_all(&args.folder)?;
    let wanted = |name: &str| args.only.as_deref().is_none_or(|n| n == name);
    for person in people::cast().iter().filter(|p| wanted(p.name)) {
        let tall = person.build.height;
        let face = Vec3::new(0.0, tall * (1.0 - person.build.head * 0.5), 0.0);
        let body = (Vec3::new(0.0, tall * 0.5, 0.0), tall * 1.08);
        let face = (face, tall * person.build.head * 1.6);
        draw_sheet(args, person.name, &person.make().0, body, face, ["idle", "walk", "run", person.strong])?;
    }
    for (kind, name) in beast::KINDS.into_iter().filter(|k| wanted(k.1)) {
        let (body, face) = ((Vec3::new(0.0, 0.85, 0.2), 2.4), (Vec3::new(0.0, 1.35, 1.0), 0.8));
        draw_sheet(args, name, &beast::make(kind, name).0, body, face, ["walk", "walk", "run", "graze"])?;
    }
    Ok(())
}

fn draw_sheet(
    args: &Args,
    name: &str,
    document: &Document,
    body: (Vec3, f32),
    face: (Vec3, f32),
    clips: [&str; 4],
) -> std::io::Result<()> {
    let primitive = &document.meshes[0].1[0];
    println!(
        "{name}: {} triangles, {} vertices, {} joints",
        primitive.indices.len() / 3,
        primitive.positions.len(),
        document.joints.len()
    );
    let shot = |clip: &str, phase: f32, yaw: f32, (middle, span): (Vec3, f32)| preview::Shot {
        clip: clip.into(),
        phase,
        yaw,
        pitch: 6.0,
        span,
        middle,
    };
    let stand = clips[0];
    let rows = [
        [
            shot(stand, 0.0, 0.0, body),
            shot(stand, 0.0, 35.0, body),
            shot(stand, 0.0, 90.0, body),
            shot(stand, 0.0, 180.0, body),
        ],
        [shot("", 0.0, 0.0, face), shot("", 0.0, 40.0, face), shot("", 0.0, 90.0, face), shot("", 0.0, 0.0, body)],
        [
            shot(clips[1], 0.0, 70.0, body),
            shot(clips[1], 0.3, 70.0, body),
            shot(clips[2], 0.1, 70.0, body),
            shot(clips[3], 0.5, 50.0, body),
        ],
    ];
    let size = 480;
    let bytes: Vec<u8> = rows.iter().flat_map(|shots| preview::sheet(document, shots, size)).collect();
    let (width, height) = ((size * rows[0].len()) as u32, (size * rows.len()) as u32);
    image::save_buffer(args.folder.join(format!("{name}.png")), &bytes, width, height, image::ExtendedColorType::Rgb8)
        .map_err(std::io::Error::other)?;
    std::fs::write(args.folder.join(format!("{name}_texture.png")), &document.images[0])
}
