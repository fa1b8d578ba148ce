//! Files that appear whole or not at all, and never over an input or over one another.

use crate::error::{BakeError, Cause, Step};
use std::ffi::OsStr;
use std::io::{Error, ErrorKind, Write};
use std::path::{Component, Path, PathBuf};

/// Writes under a temporary name in the same folder, then renames. Missing folders are made, links are followed, devices
/// and pipes written to directly.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    let fail = |source| BakeError::whole(Step::Write, Cause::Output { path: path.to_owned(), source });
    if is_device(path) {
        return std::fs::write(path, bytes).map_err(fail);
    }
    make_folder_of(path)?;
    let target = follow_link(path).map_err(fail)?;
    let mut file = temporary_in(folder_of(&target)).map_err(fail)?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(fail)?;
    file.persist(&target).map_err(|error| fail(error.error))?;
    Ok(())
}

/// Sees that a file can be made there, and the folders that it is to lie in, before hours of work rely on it. Nothing is made yet.
pub(crate) fn expect_writable(path: &Path) -> Result<(), BakeError> {
    let fail = |source| BakeError::whole(Step::Write, Cause::Output { path: path.to_owned(), source });
    if path.is_dir() {
        return Err(fail(Error::new(ErrorKind::IsADirectory, "is a folder, a file name is needed")));
    }
    if is_device(path) {
        return Ok(());
    }
    let target = follow_link(path).map_err(fail)?;
    let Some(name) = target.file_name() else {
        return Err(fail(Error::new(ErrorKind::IsADirectory, "is a folder, a file name is needed")));
    };
    let (there, missing) = split_missing(folder_of(&target))?;
    if missing.as_os_str().is_empty() {
        let found = there.join(name).symlink_metadata().map(drop);
        found.or_else(|error| if error.kind() == ErrorKind::NotFound { Ok(()) } else { Err(error) }).map_err(fail)?;
    }
    try_in(&there, &missing, Some(name)).map_err(fail)
}

/// The same for a folder whose files have no names yet.
pub(crate) fn expect_folder_writable(folder: &Path) -> Result<(), BakeError> {
    let (there, missing) = split_missing(folder)?;
    let fail = |source| BakeError::whole(Step::Write, Cause::Output { path: folder.to_owned(), source });
    try_in(&there, &missing, None).map_err(fail)
}

/// Makes a file in a folder that is there, or the missing folders and the file within a temporary one, and removes them again.
fn try_in(there: &Path, missing: &Path, name: Option<&OsStr>) -> std::io::Result<()> {
    if missing.as_os_str().is_empty() {
        return temporary_in(there).map(drop);
    }
    let trial = tempfile::Builder::new().prefix(".").suffix(".crowdpack.tmp").tempdir_in(there)?;
    let folder = trial.path().join(missing);
    std::fs::create_dir_all(&folder)?;
    match name {
        Some(name) => std::fs::File::create_new(folder.join(name)).map(drop)?,
        None => temporary_in(&folder).map(drop)?,
    }
    trial.close()
}

/// What is there of a folder, and what is to be made below it. Links that lead nowhere can be neither.
fn split_missing(folder: &Path) -> Result<(PathBuf, PathBuf), BakeError> {
    let refused = |path: &Path, source| BakeError::whole(Step::Write, Cause::Output { path: path.to_owned(), source });
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
            Ok(_) => {
                return Err(refused(&there, Error::new(ErrorKind::NotADirectory, "is a file, a folder is needed")));
            }
            Err(_) if matches!(component, Component::Prefix(_)) => {}
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(refused(&there, error)),
            Err(error) if there.is_symlink() => {
                return Err(refused(
                    &there,
                    Error::new(error.kind(), "is a link that leads nowhere, a folder is needed"),
                ));
            }
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

/// Refuses an output that is one of the inputs or one of the files that they name, however either is spelled.
pub(crate) fn refuse_inputs(output: &Path, inputs: &[PathBuf]) -> Result<(), BakeError> {
    let Ok(real) = output.canonicalize() else { return Ok(()) };
    for input in inputs {
        if input.canonicalize().is_ok_and(|input| input == real) {
            return Err(BakeError::whole(Step::Plan, Cause::OutputIsInput { path: output.to_owned() }));
        }
        // What an asset names lies in its folder or below: only then is it worth looking into.
        let folder = folder_of(input).canonicalize();
        if folder.is_ok_and(|folder| real.starts_with(folder)) && crowd_source::named_files(input).contains(&real) {
            let (path, asset) = (output.to_owned(), input.clone());
            return Err(BakeError::whole(Step::Plan, Cause::OutputIsPartOfInput { path, asset }));
        }
    }
    Ok(())
}

/// Refuses two outputs that are one file: the second would replace the first.
pub(crate) fn refuse_twins(outputs: &[&Path]) -> Result<(), BakeError> {
    let mut places: Vec<PathBuf> = Vec::new();
    for output in outputs.iter().filter(|output| !is_device(output)) {
        let place = place_of(output);
        if places.contains(&place) {
            return Err(BakeError::whole(Step::Plan, Cause::OutputTwice { path: (*output).to_owned() }));
        }
        places.push(place);
    }
    Ok(())
}

/// Where a file lies or will lie: what exists of the path without links and detours, and the rest as it stands.
fn place_of(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    match path.file_name() {
        Some(name) => place_of(folder_of(path)).join(name),
        None => path.to_owned(),
    }
}

/// Prints to stdout; a closed pipe is an error that the caller turns into success.
pub(crate) fn print(out: &mut dyn Write, text: &str) -> Result<(), BakeError> {
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|source| {
        BakeError::whole(Step::Write, Cause::Output { path: PathBuf::from("standard output"), source })
    })
}

/// Makes the folders that a file is to lie in.
pub(crate) fn make_folder_of(path: &Path) -> Result<(), BakeError> {
    let folder = folder_of(path);
    split_missing(folder)?;
    std::fs::create_dir_all(folder)
        .map_err(|source| BakeError::whole(Step::Write, Cause::Output { path: folder.to_owned(), source }))
}

/// Where a file lies: `.` for a bare name.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Devices and pipes (`/dev/null`) are written to: renaming would put a file in their place.
fn is_device(path: &Path) -> bool {
    path.metadata().is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

/// What a link points to is replaced, the link stays.
fn follow_link(path: &Path) -> std::io::Result<PathBuf> {
    if path.is_symlink() { path.canonicalize() } else { Ok(path.to_owned()) }
}

/// Named as packs' own temporary files are. A temporary file is private by default; what we write is for everyone that the umask lets in.
fn temporary_in(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".").suffix(".crowdpack.tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/er/report.json");
        write_whole(&path, b"one").unwrap();
        write_whole(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn what_can_be_made_is_told_from_what_cannot_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        std::fs::write(root.join("file"), b"x").unwrap();
        let (long, fits) = ("n".repeat(300), "n".repeat(200));
        let mut refused = vec!["file/a".to_owned(), long.clone(), format!("{long}/a"), format!("new/{long}/a")];
        refused.extend([format!("new/{long}"), "new/../file/a".to_owned()]);
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
            assert_eq!(error.exit_code(), crate::error::OUTPUT_FAILED, "{path}: {error}");
            expect_folder_writable(&root.join(path)).expect_err(path);
        }
        for path in &fine {
            expect_writable(&root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        }
        expect_folder_writable(root).unwrap();
        expect_folder_writable(&root.join("new/deep")).unwrap();
        expect_writable(Path::new("bare-name-of-a-file")).unwrap();
        assert_eq!(listing(), before);
    }

    #[test]
    fn an_input_is_found_under_another_spelling() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("a.glb");
        std::fs::write(&input, b"x").unwrap();
        let other = folder.path().join(".").join("a.glb");
        assert_eq!(refuse_inputs(&other, std::slice::from_ref(&input)).unwrap_err().exit_code(), crate::error::USAGE);
        assert!(refuse_inputs(&folder.path().join("b.glb"), &[input]).is_ok());
    }
}
