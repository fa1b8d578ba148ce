//! Files that appear whole or not at all, and never over an input or over one another.

use crate::error::{BakeError, Cause, Step};
use crowd_pack::whole_file::{self, folder_of, is_device};
use std::io::Write;
use std::path::{Component, Path, PathBuf};

/// Writes a file as a whole or not at all ([`whole_file::write`]).
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    whole_file::write(path, bytes).map_err(refused(path))
}

/// Sees that a file can be made there before hours of work rely on it. Nothing is made yet.
pub(crate) fn expect_writable(path: &Path) -> Result<(), BakeError> {
    whole_file::expect_writable(path).map_err(refused(path))
}

/// The same for a folder whose files have no names yet.
pub(crate) fn expect_folder_writable(folder: &Path) -> Result<(), BakeError> {
    whole_file::expect_folder_writable(folder).map_err(refused(folder))
}

fn refused(path: &Path) -> impl FnOnce(std::io::Error) -> BakeError {
    |source| BakeError::whole(Step::Write, Cause::Output { path: path.to_owned(), source })
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

/// A file as named from the folder of another; by its whole path where they share no root (another drive).
pub(crate) fn seen_from(path: &Path, file: &Path) -> PathBuf {
    let Some(name) = path.file_name() else { return path.to_owned() };
    // A link stays one: what an asset names lies beside it, not beside what it leads to.
    let (path, folder) = (place_of(folder_of(path)).join(name), place_of(folder_of(file)));
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return path;
    }
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    up.chain(path.components().skip(shared)).collect()
}

/// Prints to stdout; a closed pipe is an error that the caller turns into success.
pub(crate) fn print(out: &mut dyn Write, text: &str) -> Result<(), BakeError> {
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|source| {
        BakeError::whole(Step::Write, Cause::Output { path: PathBuf::from("standard output"), source })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
