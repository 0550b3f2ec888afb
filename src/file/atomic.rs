//! Never half a file: write beside the target, then rename.
//!
//! A writer that is killed leaves its temporary behind. It holds a lock on it as long as it lives, so that the next writer into
//! the same folder can tell such files from those of writers at work, and takes them away.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Names of temporary files begin and end so.
const AFFIXES: [&str; 2] = [".carpaint-", ".part"];
/// A temporary file younger than this may be one whose writer has not locked it yet.
const YOUNG: Duration = Duration::from_secs(60);

/// Writes `path` through `fill`, into a temporary file of the same folder that is renamed at the end: a reader sees the old
/// file or the new one, after a crash too. A symbolic link stays, and what it points to is replaced. On an error nothing is
/// left behind; what killed writers left in the folder is taken away.
///
/// # Errors
/// Those of [`check_output`], of the file system and of `fill`.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let target = target(path)?;
    sweep(folder(&target));
    let temporary = temporary_beside(&target).map_err(|e| Error::io(path, e))?;
    let mut writer = BufWriter::new(temporary.as_file().try_clone().map_err(|e| Error::io(path, e))?);
    fill(&mut writer)?;
    writer.flush().map_err(|e| Error::io(path, e))?;
    drop(writer);
    // Some file systems rename before they write: without this a crash could leave the new name with no content.
    temporary.as_file().sync_all().map_err(|e| Error::io(path, e))?;
    temporary.persist(&target).map_err(|e| Error::io(path, e.error))?;
    Ok(())
}

/// [`write_atomically`] for a text.
///
/// # Errors
/// Those of [`write_atomically`].
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    write_atomically(path, |w| w.write_all(text.as_bytes()).map_err(|e| Error::io(path, e)))
}

/// Whether `path` can be written, asked before the work whose result it shall hold.
///
/// # Errors
/// A folder, a special file, a link to nothing; a parent that is missing, no folder or not writable.
pub fn check_output(path: &Path) -> Result<()> {
    temporary_beside(&target(path)?).map(drop).map_err(|e| Error::io(path, e))
}

/// As [`check_output`], for a command that reads these files.
///
/// # Errors
/// As [`check_output`]; an output that would replace an input.
pub fn check_output_apart(path: &Path, inputs: &[PathBuf]) -> Result<()> {
    if inputs.iter().any(|input| place(input) == place(path)) {
        let found = "an input of the same command";
        return Err(Error::invalid(path.display().to_string(), "output", found, "another file"));
    }
    check_output(path)
}

/// Whether `path` can be a folder to write into; makes nothing.
///
/// # Errors
/// A file is there.
pub fn check_output_folder(path: &Path) -> Result<()> {
    if path.exists() && !path.is_dir() {
        return Err(Error::invalid(
            path.display().to_string(),
            "output",
            "a file",
            "a folder, or a new name",
        ));
    }
    Ok(())
}

/// Where a file is, links followed as far as it or its folder exists; as named where neither does.
pub fn place(path: &Path) -> PathBuf {
    let in_folder = || Some(folder(path).canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(in_folder).unwrap_or_else(|| path.to_owned())
}

/// The file that writing `path` replaces or makes: behind links, regular if it is there, its folder there.
fn target(path: &Path) -> Result<PathBuf> {
    let refuse = |found| Err(Error::invalid(path.display().to_string(), "output", found, "a file name"));
    let target = match (std::fs::metadata(path), path.is_symlink()) {
        (Ok(there), _) if there.is_dir() => return refuse("a folder"),
        (Ok(there), _) if !there.is_file() => return refuse("a special file"),
        (Ok(_), true) => path.canonicalize().map_err(|e| Error::io(path, e))?,
        (Err(e), true) if e.kind() == ErrorKind::NotFound => return refuse("a link to nothing"),
        _ => path.to_owned(),
    };
    match std::fs::metadata(folder(&target)).map(|there| there.is_dir()) {
        Ok(true) => Ok(target),
        Ok(false) => refuse("a name inside of what is no folder"),
        Err(e) if e.kind() == ErrorKind::NotFound => refuse("a name in a folder that does not exist"),
        Err(e) => Err(Error::io(path, e)),
    }
}

/// The folder a file is in.
pub(super) fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// An empty file in the folder of `path` that disappears when dropped.
fn temporary_beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(AFFIXES[0]).suffix(AFFIXES[1]);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What a plain create would ask for; the process's umask still applies.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let temporary = builder.tempfile_in(folder(path))?;
    // Where files have no locks, nothing is swept either.
    let _ = temporary.as_file().try_lock();
    Ok(temporary)
}

/// Removes the temporary files of killed writers, as far as that is allowed.
fn sweep(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(AFFIXES[0]) && name.ends_with(AFFIXES[1]) && is_abandoned(&entry.path()) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether nobody writes a temporary file any more.
fn is_abandoned(path: &Path) -> bool {
    let is_old = |meta: &std::fs::Metadata| {
        meta.is_file()
            && meta.modified().is_ok_and(|time| time.elapsed().is_ok_and(|elapsed| elapsed > YOUNG))
    };
    std::fs::symlink_metadata(path).is_ok_and(|meta| is_old(&meta))
        && File::open(path).is_ok_and(|file| file.try_lock().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_written_is_refused_before_and_when_writing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        write_text(&file, "old").unwrap();
        for (path, word) in [
            (folder.path().to_owned(), "a folder"),
            (folder.path().join("no/such"), "does not exist"),
            (file.join("below"), "file"),
        ] {
            for outcome in [check_output(&path), write_text(&path, "new")] {
                let message = outcome.expect_err(word).to_string();
                assert!(message.contains(word) && message.contains(&*path.to_string_lossy()), "{message}");
            }
        }
        check_output(&file).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "old", "asking changes nothing");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }

    #[test]
    fn what_killed_writers_left_is_taken_away() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let target = at("file");
        let aged = |file: &File| {
            file.set_modified(std::time::SystemTime::now() - 2 * YOUNG).unwrap();
        };
        for name in [".carpaint-old.part", "carpaint-old.part", ".carpaint-old"] {
            aged(&File::create(at(name)).unwrap());
        }
        File::create(at(".carpaint-young.part")).unwrap();
        let at_work = temporary_beside(&target).unwrap();
        aged(at_work.as_file());
        write_text(&target, "new").unwrap();
        assert!(!at(".carpaint-old.part").exists(), "nobody holds it");
        for name in ["carpaint-old.part", ".carpaint-old", ".carpaint-young.part"] {
            assert!(at(name).exists(), "{name}");
        }
        assert!(at_work.path().exists(), "its writer lives");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_special_files_left_alone() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("elsewhere")).unwrap();
        write_text(&at("elsewhere/real"), "old").unwrap();
        symlink("elsewhere/real", at("link")).unwrap();
        check_output(&at("link")).unwrap();
        write_text(&at("link"), "new").unwrap();
        assert!(at("link").is_symlink(), "the link is still one");
        assert_eq!(std::fs::read_to_string(at("elsewhere/real")).unwrap(), "new");
        symlink("nowhere", at("dangling")).unwrap();
        assert!(write_text(&at("dangling"), "x").unwrap_err().to_string().contains("a link to nothing"));
        // A socket in a folder of our own: were it replaced, nobody would miss it (unlike /dev/null).
        let socket = std::os::unix::net::UnixListener::bind(at("socket")).unwrap();
        let message = write_text(&at("socket"), "x").unwrap_err().to_string();
        assert!(message.contains("a special file"), "{message}");
        assert!(std::fs::metadata(at("socket")).unwrap().file_type().is_socket());
        drop(socket);
    }
}
