//! Films: frames piped as pictures into ffmpeg, where that is installed.

use crate::{Error, Result};
use crowd_pack::whole_file::{folder_of, target_of, temporary};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Endings of names that are films.
pub const ENDINGS: [&str; 6] = ["mp4", "mkv", "webm", "mov", "avi", "gif"];

/// Whether a name is a film's.
pub fn is_film(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ENDINGS.iter().any(|film| film.eq_ignore_ascii_case(ending)))
}

/// How the names of unfinished films begin.
const PREFIX: &str = ".crowdplay-";
/// A film that nobody has written to for so long may have been left.
const LEFT_AFTER: Duration = Duration::from_secs(3600);

/// A file of its own for ffmpeg to write, and the lock on it.
fn begin_file(
    builder: &tempfile::Builder<'_, '_>,
    folder: &Path,
) -> std::io::Result<(std::fs::File, tempfile::TempPath)> {
    loop {
        let (file, path) = builder.tempfile_in(folder)?.into_parts();
        // On Windows a lock would keep ffmpeg out; there nobody can remove what is being written.
        let is_taken = cfg!(unix) && matches!(file.try_lock(), Err(std::fs::TryLockError::WouldBlock));
        // In the moment before, another process may have found it unlocked.
        if !is_taken && path.exists() {
            return Ok((file, path));
        }
    }
}

/// Whether a file is called what [`Film::begin`] calls unfinished films.
fn is_unfinished(path: &Path) -> bool {
    let name = path.file_stem().and_then(|name| name.to_str()).unwrap_or_default();
    let middle = name.strip_prefix(PREFIX).unwrap_or_default();
    middle.len() == 6 && middle.bytes().all(|byte| byte.is_ascii_alphanumeric()) && is_film(path)
}

/// Removes unfinished films of processes that were killed: those that nobody holds or has written to for an hour (locks do not reach
/// other machines everywhere). What cannot be removed stays.
fn remove_leftovers(folder: &Path) {
    let Ok(files) = std::fs::read_dir(folder) else { return };
    for path in files.filter_map(|file| Some(file.ok()?.path())) {
        let rests = |found: &std::fs::Metadata| {
            found.modified().is_ok_and(|then| then.elapsed().is_ok_and(|gone| gone >= LEFT_AFTER))
        };
        if is_unfinished(&path)
            && path.symlink_metadata().is_ok_and(|found| found.is_file() && rests(&found))
            && let Ok(file) = std::fs::OpenOptions::new().write(true).open(&path)
            && file.try_lock().is_ok()
        {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// Writes a file to a device, whose rights stay as they are.
fn copy(from: &Path, device: &Path) -> std::io::Result<()> {
    let mut device = std::fs::OpenOptions::new().write(true).open(device)?;
    std::io::copy(&mut std::fs::File::open(from)?, &mut device).map(drop)
}

/// A film being made. Dropped before its end, it leaves nothing behind.
pub struct Film {
    /// Ends before what it writes is removed.
    ffmpeg: Ffmpeg,
    /// As it was typed.
    path: PathBuf,
    /// What is replaced: a link's target, the link stays. None where a device or pipe is written to.
    target: Option<PathBuf>,
    /// What ffmpeg writes; renamed at the end, or copied to the device.
    unfinished: tempfile::TempPath,
    /// Held as long as somebody makes the film: what nobody holds was left by a process that was killed.
    lock: std::fs::File,
    /// What it complains of.
    said: std::fs::File,
}

/// Killed when nobody wants its film any more.
struct Ffmpeg(Child);

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // One that has ended cannot be killed, which is no trouble.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Film {
    /// Starts ffmpeg. `dt_s`: seconds a frame; 0 counts as 1/30.
    ///
    /// # Errors
    /// [`Error::Machine`] where there is no ffmpeg, [`Error::Output`] where the folder cannot be written to.
    pub fn begin(path: &Path, dt_s: f32) -> Result<Self> {
        let refused = |source| Error::Output { path: path.to_owned(), source };
        let target = target_of(path).map_err(refused)?;
        // Films are not written in one go: a pipe gets the whole one.
        let folder = target.as_deref().map_or_else(std::env::temp_dir, |target| folder_of(target).to_owned());
        std::fs::create_dir_all(&folder).map_err(refused)?;
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        // ffmpeg knows the format by the ending.
        let suffix = format!(".{ending}");
        remove_leftovers(&folder);
        let (lock, unfinished) = begin_file(&temporary(PREFIX, &suffix), &folder).map_err(refused)?;
        let said = tempfile::tempfile().map_err(refused)?;
        let rate_hz = if dt_s > 0.0 { (1.0 / dt_s).clamp(0.01, 1000.0) } else { 30.0 };
        let mut command = Command::new("ffmpeg");
        command.args(["-loglevel", "error", "-y", "-f", "image2pipe", "-c:v", "png", "-framerate"]);
        command.arg(format!("{rate_hz:.4}")).args(["-i", "-"]);
        if ending != "gif" {
            // What players know; it has colours for two by two pixels.
            command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]);
        }
        command.arg(&*unfinished).stdin(Stdio::piped()).stdout(Stdio::null());
        command.stderr(said.try_clone().map_err(refused)?);
        let ffmpeg = command.spawn().map_err(|error| Error::Machine {
            what: format!("a film needs ffmpeg, which does not start: {error}"),
            remedy: "install it, or write pictures (--out frame-%04d.png)",
        })?;
        Ok(Self { ffmpeg: Ffmpeg(ffmpeg), path: path.to_owned(), target, unfinished, lock, said })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`Error::Output`] when ffmpeg has given up, with its words.
    pub fn add(&mut self, png: &[u8]) -> Result<()> {
        let pipe = self.ffmpeg.0.stdin.as_mut().expect("it was asked for, and is taken at the end alone");
        pipe.write_all(png).map_err(|_| self.failure())
    }

    /// Ends the film and puts it in its place.
    ///
    /// # Errors
    /// [`Error::Output`] when ffmpeg did not make it, with its words.
    pub fn end(mut self) -> Result<()> {
        drop(self.ffmpeg.0.stdin.take());
        match self.ffmpeg.0.wait() {
            Ok(status) if status.success() => {}
            _ => return Err(self.failure()),
        }
        let Self { path, target, unfinished, lock, .. } = self;
        let ended = match target {
            Some(target) => unfinished.persist(target).map_err(|error| error.error),
            None => copy(&unfinished, &path),
        };
        drop(lock);
        ended.map_err(|source| Error::Output { path, source })
    }

    fn failure(&mut self) -> Error {
        // Nothing more comes in: it ends by itself.
        drop(self.ffmpeg.0.stdin.take());
        let _ = self.ffmpeg.0.wait();
        let mut words = Vec::new();
        let _ = self.said.rewind();
        let _ = (&self.said).take(2000).read_to_end(&mut words);
        let words = String::from_utf8_lossy(&words).trim().replace('\n', "; ");
        Error::Output { path: self.path.clone(), source: std::io::Error::other(format!("ffmpeg: {words}")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_killed_processes_left_is_removed_and_what_is_being_made_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let others = [".crowdplay-note12.txt", ".crowdplay-my-film.mp4", "film.mp4", "crowdplay-abc123.mp4"];
        let others = others.map(|name| folder.path().join(name));
        let [left, fresh] = ["abc123", "def456"].map(|name| folder.path().join(format!("{PREFIX}{name}.mp4")));
        others.iter().chain([&left, &fresh]).for_each(|path| std::fs::write(path, "x").unwrap());
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(".mkv");
        let (lock, made) = begin_file(&builder, folder.path()).unwrap();
        let long_ago = std::time::SystemTime::now() - 2 * LEFT_AFTER;
        for path in others.iter().map(PathBuf::as_path).chain([left.as_path(), &*made]) {
            std::fs::File::options().write(true).open(path).unwrap().set_modified(long_ago).unwrap();
        }
        remove_leftovers(folder.path());
        assert!(!left.exists() && fresh.exists() && others.iter().all(|path| path.exists()));
        assert!(made.exists() || cfg!(not(unix)));
        // No test of this program starts another one: nobody else holds what is let go.
        drop(lock);
        remove_leftovers(folder.path());
        assert!(!made.exists(), "nobody makes it any more");
    }

    #[test]
    fn films_are_known_by_their_ending() {
        for film in ["a.mp4", "b/c.MKV", "d.gif"] {
            assert!(is_film(Path::new(film)), "{film}");
        }
        for other in ["a.png", "mp4", "a.mp4.png", "-"] {
            assert!(!is_film(Path::new(other)), "{other}");
        }
    }
}
