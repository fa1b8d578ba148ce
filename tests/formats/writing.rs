//! Files: whole or not at all, and the errors name them.

use crate::tiny_pack;
use crowd_pack::{AnimationLayout, Error, Pack};
use std::fs;

#[test]
fn a_written_pack_opens_and_the_report_adds_up() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crowd.crowdpack");
    let contents = tiny_pack::contents(AnimationLayout::Premultiplied3x4);
    let report = contents.write(&path).unwrap();
    assert_eq!(report.pack_bytes, fs::metadata(&path).unwrap().len());
    assert_eq!(report.sections.len(), 18);
    assert_eq!(report.sections[2], ("vertices".to_owned(), 9 * 48));
    assert_eq!(Pack::open(&path).unwrap().contents(), &contents);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left in the folder");
}

#[test]
fn a_failed_write_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crowd.crowdpack");
    fs::write(&path, "old").unwrap();
    let mut contents = tiny_pack::contents(AnimationLayout::Premultiplied3x4);
    contents.materials[0].reserved = 1;
    assert!(matches!(contents.write(&path), Err(Error::Format { .. })));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);

    // A folder stands where the file should go: the rename fails, and nothing is left behind.
    let taken = folder.path().join("taken.crowdpack");
    fs::create_dir(&taken).unwrap();
    let error = tiny_pack::contents(AnimationLayout::Premultiplied3x4).write(&taken).unwrap_err();
    assert!(
        matches!(&error, Error::Io { path, .. } if *path == taken) && error.to_string().contains("taken"),
        "{error}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn missing_folders_are_made_and_what_is_in_the_way_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let contents = tiny_pack::contents(AnimationLayout::Premultiplied3x4);
    fs::write(folder.path().join("file"), "not a folder").unwrap();
    let (nowhere, below) = (folder.path().join("no/where.crowdpack"), folder.path().join("file/where.crowdpack"));
    for (error, asked) in [(contents.write(&below).unwrap_err(), &below), (Pack::open(&nowhere).unwrap_err(), &nowhere)]
    {
        assert!(matches!(&error, Error::Io { path, .. } if path == asked), "{error}");
        assert!(error.to_string().contains("where.crowdpack"));
    }
    contents.write(&nowhere).unwrap();
    Pack::open(&nowhere).unwrap();
    assert!(matches!(Pack::open(folder.path()), Err(Error::Io { .. })), "a folder is not a pack");
}

#[test]
fn opening_looks_at_the_length_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("short.crowdpack");
    let bytes = tiny_pack::contents(AnimationLayout::Premultiplied3x4).to_bytes().unwrap();
    for length in [0, 63, 64, 640, bytes.len() - 1] {
        fs::write(&path, &bytes[..length]).unwrap();
        assert!(matches!(Pack::open(&path), Err(Error::Format { .. })), "{length} bytes");
    }
    // A hole of nine gibibytes takes no room on the disk and none in memory.
    let file = fs::File::create(&path).unwrap();
    if file.set_len(9 << 30).is_ok() {
        drop(file);
        let error = Pack::open(&path).unwrap_err();
        assert!(matches!(error, Error::Limit { allowed, .. } if allowed == 8 << 30), "{error}");
    }
}

#[cfg(unix)]
#[test]
fn a_new_pack_has_the_permissions_of_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (pack, plain) = (folder.path().join("crowd.crowdpack"), folder.path().join("plain"));
    tiny_pack::contents(AnimationLayout::Premultiplied3x4).write(&pack).unwrap();
    fs::write(&plain, "").unwrap();
    let mode = |path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&pack), mode(&plain));
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real.crowdpack"), folder.path().join("link.crowdpack"));
    fs::write(&real, "old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    tiny_pack::contents(AnimationLayout::Premultiplied3x4).write(&link).unwrap();
    assert!(link.is_symlink() && !real.is_symlink());
    assert!(Pack::open(&real).is_ok());
}
