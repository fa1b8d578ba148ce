//! `crowd-fixtures DIR` rewrites the fixtures; `crowd-fixtures --preview DIR` draws contact sheets of the characters.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use crowd_fixtures::{generate, people, preview};
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
    for person in people::cast() {
        if args.only.as_deref().is_some_and(|n| n != person.name) {
            continue;
        }
        let (document, _) = person.make();
        let primitive = &document.meshes[0].1[0];
        println!("{}: {} triangles, {} vertices, {} joints", person.name, primitive.indices.len() / 3, primitive.positions.len(), document.joints.len());
        let tall = person.build.height;
        let body = Vec3::new(0.0, tall * 0.5, 0.0);
        let face = Vec3::new(0.0, tall * (1.0 - person.build.head * 0.5), 0.0);
        let shot = |clip: &str, phase: f32, yaw: f32, span: f32, middle: Vec3| preview::Shot {
            clip: clip.into(),
            phase,
            yaw,
            pitch: 6.0,
            span,
            middle,
        };
        let wide = tall * 1.08;
        let stands = [
            shot("idle", 0.0, 0.0, wide, body),
            shot("idle", 0.0, 35.0, wide, body),
            shot("idle", 0.0, 90.0, wide, body),
            shot("idle", 0.0, 180.0, wide, body),
        ];
        let faces = [
            shot("", 0.0, 0.0, tall * 0.22, face),
            shot("", 0.0, 40.0, tall * 0.22, face),
            shot("", 0.0, 90.0, tall * 0.22, face),
            shot("", 0.0, 0.0, wide, body),
        ];
        let moves = [
            shot("walk", 0.0, 70.0, wide, body),
            shot("walk", 0.3, 70.0, wide, body),
            shot("run", 0.1, 70.0, wide, body),
            shot(person.strong, 0.5, 50.0, wide, body),
        ];
        for (n, shots) in [&stands, &faces, &moves].into_iter().enumerate() {
            let size = 480;
            let bytes = preview::sheet(&document, shots, size);
            let path = args.folder.join(format!("{}_{n}.png", person.name));
            image::save_buffer(&path, &bytes, (size * shots.len()) as u32, size as u32, image::ExtendedColorType::Rgb8)
                .map_err(std::io::Error::other)?;
        }
        std::fs::write(args.folder.join(format!("{}_texture.png", person.name)), &document.images[0])?;
    }
    Ok(())
}
