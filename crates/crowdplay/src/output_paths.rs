//! No output may fall on an input or on another output, however the two are spelled.

use crate::picture::is_device;
use crate::plan::{CameraPlan, FeedPlan, HeadlessPlan, LayoutPlan, MotionPlanWord, Plan, Show, WindowPlan};
use crate::{Error, Result};
use std::ffi::OsStr;
use std::io::{self, ErrorKind};
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
    let refused = |source| Error::Output { path: path.to_owned(), source };
    if path == Path::new("-") {
        return Ok(());
    }
    let no_name = || refused(io::Error::new(ErrorKind::IsADirectory, "is a folder, a file name is needed"));
    if path.is_dir() {
        return Err(no_name());
    }
    if is_device(path) {
        return Ok(());
    }
    let target = if path.is_symlink() { path.canonicalize().map_err(refused)? } else { path.to_owned() };
    let name = target.file_name().ok_or_else(no_name)?;
    let (there, missing) = split_missing(target.parent().unwrap_or(Path::new(""))).map_err(refused)?;
    try_in(&there, &missing, name).map_err(refused)
}

/// Makes a file in a folder that is there, or the missing folders and the file within a temporary one, and removes them again.
fn try_in(there: &Path, missing: &Path, name: &OsStr) -> io::Result<()> {
    if missing.as_os_str().is_empty() {
        return match there.join(name).symlink_metadata() {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
            _ => tempfile::tempfile_in(there).map(drop),
        };
    }
    let trial = tempfile::Builder::new().prefix(".crowdplay-").suffix(".tmp").tempdir_in(there)?;
    let folder = trial.path().join(missing);
    std::fs::create_dir_all(&folder)?;
    std::fs::File::create_new(folder.join(name))?;
    trial.close()
}

/// What is there of a folder, and what is to be made below it. Links that lead nowhere can be neither.
fn split_missing(folder: &Path) -> io::Result<(PathBuf, PathBuf)> {
    let refused = |path: &Path, kind, what: &str| {
        Err(io::Error::new(kind, format!("{} {what}, a folder is needed", path.display())))
    };
    let (mut there, mut missing) = (PathBuf::new(), PathBuf::new());
    for component in folder.components() {
        match component {
            Component::CurDir => continue,
            // What is missing will be made as real folders: above is above.
            Component::ParentDir if missing.pop() => continue,
            Component::Normal(name) if !missing.as_os_str().is_empty() => {
                missing.push(name);
                continue;
            }
            other => there.push(other),
        }
        match there.metadata() {
            Ok(found) if found.is_dir() => {}
            Ok(_) => return refused(&there, ErrorKind::NotADirectory, "is a file"),
            Err(_) if matches!(component, Component::Prefix(_)) => {}
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            Err(error) if there.is_symlink() => return refused(&there, error.kind(), "is a link that leads nowhere"),
            Err(_) => {
                missing.extend(there.file_name());
                there.pop();
            }
        }
    }
    if there.as_os_str().is_empty() {
        there.push(".");
    }
    Ok((there, missing))
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
    fn what_can_be_made_is_told_from_what_cannot_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        std::fs::write(root.join("file"), b"x").unwrap();
        let (long, fits) = ("n".repeat(300), "n".repeat(200));
        let mut refused = vec!["file/a".to_owned(), long.clone(), format!("{long}/a"), format!("new/{long}/a")];
        refused.extend([format!("new/{long}"), "new/../file/a".to_owned(), String::new()]);
        let fine = ["a", "file", "new/deep/a", "new/../a", "new/../../a", &fits, &format!("{fits}/{fits}")];
        let mut fine = fine.map(str::to_owned).to_vec();
        #[cfg(unix)]
        {
            std::fs::create_dir(root.join("there")).unwrap();
            for (target, link) in [("gone", "nowhere"), ("there", "somewhere"), ("there/a", "linked"), ("self", "self")]
            {
                std::os::unix::fs::symlink(target, root.join(link)).unwrap();
            }
            std::fs::write(root.join("there/a"), b"x").unwrap();
            refused.extend(["nowhere", "nowhere/a", "nowhere/new/a", "new/../nowhere/a", "self/a"].map(str::to_owned));
            fine.extend(["linked", "somewhere/a", "somewhere/new/a", "somewhere/../new/a"].map(str::to_owned));
        }
        let listing = || {
            let mut names: Vec<_> = std::fs::read_dir(root).unwrap().map(|item| item.unwrap().file_name()).collect();
            names.sort();
            names
        };
        let before = listing();
        for path in &refused {
            let error = expect_writable(&root.join(path)).expect_err(path);
            assert!(matches!(error, Error::Output { .. }), "{path}: {error}");
        }
        for path in &fine {
            expect_writable(&root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        }
        expect_writable(Path::new("-")).unwrap();
        assert_eq!(listing(), before);
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
