//! Draws the characters, proofs and scenes under `fixtures/`, the same bytes every time.
//!
//! Bodies are modelled as stacks of rings bridged into one closed surface, painted from bind-pose positions, weighted along
//! their limbs and moved by hand-written gaits. Every file is made from numbers in this crate; nothing is read.

pub mod assemble;
pub mod atlas;
pub mod bad;
pub mod beast;
pub mod body;
pub mod glb;
pub mod human_clips;
pub mod human_rig;
pub mod motion;
pub mod paint_human;
pub mod people;
mod person;
pub mod preview;
pub mod profile;
pub mod proofs;
pub mod scenes;
pub mod shape;
pub mod sqlite_file;
pub mod wear;

/// One file below the fixtures folder.
#[derive(Clone, Debug)]
pub struct Fixture {
    /// Path below the folder, with `/`.
    pub path: String,
    /// Contents.
    pub bytes: Vec<u8>,
}

/// Makes every fixture, sorted by path.
pub fn generate() -> Vec<Fixture> {
    let mut out = Vec::new();
    for person in people::cast() {
        let (document, regions) = person.make();
        out.push(Fixture { path: format!("good/{}.glb", person.name), bytes: document.to_glb() });
        out.push(Fixture { path: format!("good/{}.regions.png", person.name), bytes: regions });
    }
    for (kind, name) in beast::KINDS {
        let (document, regions) = beast::make(kind, name);
        out.push(Fixture { path: format!("good/{name}.glb"), bytes: document.to_glb() });
        out.push(Fixture { path: format!("good/{name}.regions.png"), bytes: regions });
    }
    out.extend(proofs::proofs());
    out.extend(bad::refusals());
    out.extend(scenes::scenes());
    out.sort_by(|a, b| a.path.cmp(&b.path));
    out
}
