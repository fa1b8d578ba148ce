//! Files that appear whole or not at all: packs, and all that the commands write beside them.
//!
//! One way for every output: under a temporary name in the same folder, then renamed. Links are followed and stay, devices and pipes are written to,
//! missing folders are made. What cannot be made can be told beforehand.

use std::ffi::OsStr;
use std::io::{Error, ErrorKind, Result, Write};
use std::path::{Component, Path, PathBuf};

/// How the name of an unfinished file ends.
const SUFFIX: &str = ".crowdpack.tmp";

/// Writes a file: the old one or the new one is there, never half.
///
/// # Errors
/// The system's, a part of the path that is no folder, and more bytes than the system lets this program write (`ulimit -f`).
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let Some(target) = target_of(path)? else { return std::fs::write(path, bytes) };
    let folder = folder_of(&target);
    split_missing(folder)?;
    expect_allowed_size(bytes.len() as u64, most_bytes(std::fs::read_to_string(LIMITS).ok().as_deref()))?;
    std::fs::create_dir_all(folder)?;
    let mut file = temporary(".", SUFFIX).tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(&target)?;
    // The rename lasts through a power cut only once the folder is on the disk. The new file is in place by now, so a
    // system that cannot sync folders is no failure of ours.
    #[cfg(unix)]
    let _ = std::fs::File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Sees that a file can be made there, and the folders that it is to lie in, before hours of work rely on it. Nothing is made yet.
///
/// # Errors
/// What [`write()`] would end with, and a folder of that name.
pub fn expect_writable(path: &Path) -> Result<()> {
    let no_name = || Error::new(ErrorKind::IsADirectory, "is a folder, a file name is needed");
    if path.is_dir() {
        return Err(no_name());
    }
    let Some(target) = target_of(path)? else { return Ok(()) };
    let name = target.file_name().ok_or_else(no_name)?;
    let (there, missing) = split_missing(folder_of(&target))?;
    if missing.as_os_str().is_empty() {
        match there.join(name).symlink_metadata() {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    try_in(&there, &missing, Some(name))
}

/// The same for a folder whose files have no names yet.
///
/// # Errors
/// What [`write()`] would end with.
pub fn expect_folder_writable(folder: &Path) -> Result<()> {
    let (there, missing) = split_missing(folder)?;
    try_in(&there, &missing, None)
}

/// What is replaced when a file is written: what a link points to, the link stays. `None` for devices and pipes (`/dev/null`), which are
/// written to: renaming would put a file in their place.
///
/// # Errors
/// A link that leads nowhere.
pub fn target_of(path: &Path) -> Result<Option<PathBuf>> {
    match path {
        path if is_device(path) => Ok(None),
        path if path.is_symlink() => path.canonicalize().map(Some),
        path => Ok(Some(path.to_owned())),
    }
}

/// Neither a file nor a folder, but there.
pub fn is_device(path: &Path) -> bool {
    path.metadata().is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

/// What this program may do, where Linux says it.
const LIMITS: &str = "/proc/self/limits";

/// The most bytes that a file of ours may have, as far as the system says: the first number in the line of [`LIMITS`].
fn most_bytes(limits: Option<&str>) -> Option<u64> {
    let line = limits?.lines().find_map(|line| line.strip_prefix("Max file size"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// A write beyond the limit does not fail: a signal ends the program, and leaves the unfinished file. So it is asked first.
fn expect_allowed_size(bytes: u64, most: Option<u64>) -> Result<()> {
    match most {
        Some(most) if bytes > most => {
            let what = format!("{bytes} bytes, files may have {most}: raise the limit (ulimit -f)");
            Err(Error::new(ErrorKind::FileTooLarge, what))
        }
        _ => Ok(()),
    }
}

/// Where a file lies: `.` for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A maker of unfinished files. They are private by default; what is written is for everyone that the umask lets in.
pub fn temporary<'a>(prefix: &'a str, suffix: &'a str) -> tempfile::Builder<'a, 'a> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(suffix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// Makes a file in a folder that is there, or the missing folders and the file within a temporary one, and removes them again.
fn try_in(there: &Path, missing: &Path, name: Option<&OsStr>) -> Result<()> {
    if missing.as_os_str().is_empty() {
        return temporary(".", SUFFIX).tempfile_in(there).map(drop);
    }
    let trial = tempfile::Builder::new().prefix(".").suffix(SUFFIX).tempdir_in(there)?;
    let folder = trial.path().join(missing);
    std::fs::create_dir_all(&folder)?;
    match name {
        Some(name) => std::fs::File::create_new(folder.join(name)).map(drop)?,
        None => temporary(".", SUFFIX).tempfile_in(&folder).map(drop)?,
    }
    trial.close()
}

/// What is there of a folder, and what is to be made below it. Links that lead nowhere can be neither.
fn split_missing(folder: &Path) -> Result<(PathBuf, PathBuf)> {
    let refused =
        |path: &Path, kind, what: &str| Err(Error::new(kind, format!("{} {what}, a folder is needed", path.display())));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_told_from_files() {
        assert!(!is_device(Path::new(env!("CARGO_MANIFEST_DIR"))));
        assert!(!is_device(&Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")));
        assert!(!is_device(Path::new("no such file")));
        #[cfg(unix)]
        assert!(is_device(Path::new("/dev/null")));
    }

    #[test]
    fn the_largest_file_is_what_the_system_says() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units\n\
                      Max cpu time              unlimited            unlimited            seconds\n\
                      Max file size             4096                 unlimited            bytes\n";
        assert_eq!(most_bytes(Some(limits)), Some(4096));
        assert_eq!(most_bytes(Some(&limits.replace("4096", "unlimited"))), None);
        assert_eq!([most_bytes(Some("")), most_bytes(None)], [None, None]);
        for (most, fits) in [(None, true), (Some(4096), true), (Some(4095), false), (Some(0), false)] {
            assert_eq!(expect_allowed_size(4096, most).is_ok(), fits);
        }
    }

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("deep/er/report.json");
        write(&path, b"one").expect("folders are made");
        write(&path, b"two").expect("it is replaced");
        assert_eq!(std::fs::read(&path).expect("it is there"), b"two");
        assert_eq!(std::fs::read_dir(folder_of(&path)).expect("it is there").count(), 1);
    }

    #[test]
    fn what_can_be_made_is_told_from_what_cannot_and_nothing_is_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        std::fs::write(root.join("file"), b"x").expect("it is ours");
        let (long, fits) = ("n".repeat(300), "n".repeat(200));
        let mut refused = vec!["file/a".to_owned(), long.clone(), format!("{long}/a"), format!("new/{long}/a")];
        refused.extend([format!("new/{long}"), "new/../file/a".to_owned()]);
        let fine = ["a", "file", "new/deep/a", "new/../a", "new/../../a", &fits, &format!("{fits}/{fits}")];
        let mut fine = fine.map(str::to_owned).to_vec();
        #[cfg(unix)]
        {
            std::fs::create_dir(root.join("there")).expect("it is ours");
            for (target, link) in [("gone", "nowhere"), ("there", "somewhere"), ("there/a", "linked"), ("self", "self")]
            {
                std::os::unix::fs::symlink(target, root.join(link)).expect("it is ours");
            }
            std::fs::write(root.join("there/a"), b"x").expect("it is ours");
            refused.extend(["nowhere", "nowhere/a", "nowhere/new/a", "new/../nowhere/a", "self/a"].map(str::to_owned));
            fine.extend(["linked", "somewhere/a", "somewhere/new/a", "somewhere/../new/a"].map(str::to_owned));
        }
        let listing = || {
            let items = std::fs::read_dir(root).expect("it is there");
            let mut names: Vec<_> = items.map(|item| item.expect("it is there").file_name()).collect();
            names.sort();
            names
        };
        let before = listing();
        for path in &refused {
            expect_writable(&root.join(path)).expect_err(path);
            expect_folder_writable(&root.join(path)).expect_err(path);
        }
        expect_writable(root).expect_err("a folder");
        for path in &fine {
            expect_writable(&root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        }
        expect_folder_writable(root).expect("it is ours");
        expect_folder_writable(&root.join("new/deep")).expect("it can be made");
        expect_writable(Path::new("bare-name-of-a-file")).expect("here");
        assert_eq!(listing(), before);
        // And so it comes.
        for path in refused {
            write(&root.join(&path), b"x").expect_err(&path);
        }
    }
}
