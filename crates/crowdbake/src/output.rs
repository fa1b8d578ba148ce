//! Files that appear whole or not at all, and never over an input.

use crate::error::{BakeError, Cause, Step};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes under a temporary name in the same folder, then renames. Missing folders are made.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    let fail = |source| BakeError::whole(Step::Write, Cause::Output { path: path.to_owned(), source });
    make_folder_of(path)?;
    let mut file = temporary_beside(path).map_err(fail)?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(fail)?;
    file.persist(path).map_err(|error| fail(error.error))?;
    Ok(())
}

/// Makes the folder that `path` lies in and sees that a file can be made there, before hours of work rely on it.
pub(crate) fn expect_writable(path: &Path) -> Result<(), BakeError> {
    let fail = |source| BakeError::whole(Step::Write, Cause::Output { path: path.to_owned(), source });
    if path.is_dir() {
        return Err(fail(std::io::Error::new(std::io::ErrorKind::IsADirectory, "is a folder, a file name is needed")));
    }
    make_folder_of(path)?;
    temporary_beside(path).map(drop).map_err(fail)
}

/// Refuses an output that is one of the inputs, however either is spelled.
pub(crate) fn refuse_inputs(output: &Path, inputs: &[PathBuf]) -> Result<(), BakeError> {
    let Ok(real) = output.canonicalize() else { return Ok(()) };
    if inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == real)) {
        return Err(BakeError::whole(Step::Plan, Cause::OutputIsInput { path: output.to_owned() }));
    }
    Ok(())
}

/// Prints to stdout; a closed pipe is an error that the caller turns into success.
pub(crate) fn print(out: &mut dyn Write, text: &str) -> Result<(), BakeError> {
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|source| {
        BakeError::whole(Step::Write, Cause::Output { path: PathBuf::from("standard output"), source })
    })
}

fn make_folder_of(path: &Path) -> Result<(), BakeError> {
    let folder = folder_of(path);
    std::fs::create_dir_all(folder)
        .map_err(|source| BakeError::whole(Step::Write, Cause::Output { path: folder.to_owned(), source }))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A temporary file is private by default; what we write is for everyone that the umask lets in.
fn temporary_beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".crowdbake-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder_of(path))
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
    fn an_input_is_found_under_another_spelling() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("a.glb");
        std::fs::write(&input, b"x").unwrap();
        let other = folder.path().join(".").join("a.glb");
        assert_eq!(refuse_inputs(&other, std::slice::from_ref(&input)).unwrap_err().exit_code(), crate::error::USAGE);
        assert!(refuse_inputs(&folder.path().join("b.glb"), &[input]).is_ok());
    }
}
