//! No output may fall on an input or on another output, however the two are spelled.

use crate::plan::{CameraPlan, FeedPlan, HeadlessPlan, LayoutPlan, MotionPlanWord, Plan, Show, WindowPlan};
use crate::{Error, Result};
use crowd_pack::whole_file::{self, is_device};
use std::path::{Component, Path, PathBuf};

/// Refuses a picture or report that would replace the pack, the layout file, the camera path, or one another. Devices
/// and pipes may take several outputs.
///
/// # Errors
/// [`Error::Parameter`] naming both.
pub fn refuse_shared(plan: &Plan) -> Result<()> {
    let mut taken = inputs(plan);
    if let Some(report) = plan.report.as_deref().filter(|report| *report != Path::new("-")) {
        refuse("--report", report, &places(&taken))?;
        taken.push(("--report", report));
    }
    if let Some(path) = &plan.record_camera {
        refuse("--record-camera", path, &places(&taken))?;
        taken.push(("--record-camera", path));
    }
    if let Show::Window(WindowPlan { screenshot: Some(path), .. }) = &plan.show {
        refuse("--screenshot", path, &places(&taken))?;
    }
    let Show::Headless(HeadlessPlan { frames, out: Some(out), .. }) = &plan.show else { return Ok(()) };
    let taken = places(&taken);
    let mut files = (0..*frames).filter_map(|frame| out.file_of(frame, *frames));
    files.try_for_each(|file| refuse("--out", &file, &taken))
}

/// Refuses an output that would replace an input.
///
/// # Errors
/// [`Error::Parameter`] naming both.
pub fn refuse_inputs(plan: &Plan, option: &'static str, output: &Path) -> Result<()> {
    if output == Path::new("-") { Ok(()) } else { refuse(option, output, &places(&inputs(plan))) }
}

/// What will be written, the first file of many; nothing that goes to standard output.
pub fn outputs(plan: &Plan) -> Vec<PathBuf> {
    let picture = match &plan.show {
        Show::Headless(HeadlessPlan { out, .. }) => out.as_ref().and_then(|out| out.file_of(0, 1)),
        Show::Window(WindowPlan { screenshot, .. }) => screenshot.clone(),
    };
    let report = plan.report.clone().filter(|report| report != Path::new("-"));
    [picture, report, plan.record_camera.clone()].into_iter().flatten().collect()
}

/// Sees that a file can be made there, before hours of work rely on it. Nothing is made yet.
///
/// # Errors
/// [`Error::Output`] where it cannot.
pub fn expect_writable(path: &Path) -> Result<()> {
    if path == Path::new("-") {
        return Ok(());
    }
    whole_file::expect_writable(path).map_err(|source| Error::Output { path: path.to_owned(), source })
}

fn inputs(plan: &Plan) -> Vec<(&'static str, &Path)> {
    let mut taken = vec![("the pack", plan.pack.as_path())];
    match &plan.crowd.layout {
        LayoutPlan::Named(_) => {}
        LayoutPlan::File(path) => taken.push(("--layout", path)),
        LayoutPlan::Feed(FeedPlan::Trajectories { path, .. }) => taken.push(("--trajectories", path)),
        LayoutPlan::Feed(FeedPlan::Walk { path: Some(path) }) => taken.push(("--walk", path)),
        LayoutPlan::Feed(FeedPlan::Walk { path: None } | FeedPlan::Flock { .. }) => {}
    }
    if let Some(path) = &plan.crowd.walkable {
        taken.push(("--walkable", path));
    }
    if let MotionPlanWord::File(path) = &plan.crowd.motion {
        taken.push(("--motion-graph", path));
    }
    if let CameraPlan::Path { path } = &plan.camera {
        taken.push(("--camera-path", path));
    }
    taken
}

/// A file that is spoken for: by whom, as it was typed, and where it lies.
struct Taken<'a> {
    whose: &'static str,
    typed: &'a Path,
    place: PathBuf,
}

fn places<'a>(taken: &[(&'static str, &'a Path)]) -> Vec<Taken<'a>> {
    taken.iter().map(|&(whose, typed)| Taken { whose, typed, place: place_of(typed) }).collect()
}

fn refuse(option: &'static str, output: &Path, taken: &[Taken<'_>]) -> Result<()> {
    if is_device(output) {
        return Ok(());
    }
    let place = place_of(output);
    taken.iter().find(|other| other.place == place).map_or(Ok(()), |other| {
        Err(Error::Parameter {
            option,
            found: format!("{}, the same file as {} {}", output.display(), other.whose, other.typed.display()),
            allowed: "a file of its own".to_owned(),
        })
    })
}

/// Absolute, links followed, whether or not the file and its folders are there yet.
fn place_of(path: &Path) -> PathBuf {
    let Ok(absolute) = std::path::absolute(path) else { return path.to_owned() };
    let mut place = PathBuf::new();
    for component in absolute.components() {
        match component {
            // What is there is real by now, and what is not will be made as real folders: above is above.
            Component::ParentDir => {
                place.pop();
            }
            other => place.push(other),
        }
        if let Ok(real) = place.canonicalize() {
            place = real;
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_output_can_be_written_to_and_a_folder_cannot() {
        assert!(expect_writable(Path::new("-")).is_ok());
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(expect_writable(folder.path()), Err(Error::Output { .. })));
        assert!(expect_writable(&folder.path().join("a/b")).is_ok());
    }

    #[test]
    fn places_do_not_depend_on_the_spelling() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        std::fs::create_dir(root.join("a")).unwrap();
        let place = place_of(&root.join("a/x.png"));
        assert_eq!(place_of(&root.join("./a/../a//x.png")), place);
        assert_eq!(place_of(&root.join("missing/../a/x.png")), place);
        assert_ne!(place_of(&root.join("missing/a/x.png")), place);
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("a", root.join("b")).unwrap();
            assert_eq!(place_of(&root.join("b/x.png")), place);
            std::fs::write(root.join("a/x.png"), "").unwrap();
            std::os::unix::fs::symlink("a/x.png", root.join("link")).unwrap();
            assert_eq!(place_of(&root.join("link")), place);
        }
    }
}
