//! Output files that appear complete or not at all, and never replace anything that would be lost.

use std::fs::{self, File, Metadata};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// An output file that was not written. No part of it is left behind, and a previous file of that name is
/// unchanged.
#[derive(Debug, Error)]
#[error("{}: cannot be written: {reason}", path.display())]
pub struct OutputError {
    /// The path that was to be written.
    pub path: PathBuf,
    /// What went wrong.
    pub reason: io::Error,
}

/// Writes a file through `content`, completely or not at all: [`prepare`], then [`Prepared::publish`].
///
/// # Errors
/// As for these two.
pub fn write_atomically<F>(path: &Path, content: F) -> Result<(), OutputError>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    prepare(path, content)?.publish()
}

/// An output file that is complete and on the disk, but does not have its name yet. If dropped, it leaves
/// nothing behind.
#[must_use = "the file has no name before it is published"]
#[derive(Debug)]
pub struct Prepared {
    /// The name that the user gave, for error messages.
    path: PathBuf,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    /// The target is no regular file (`/dev/stdout`, a pipe) and cannot be replaced: the text is kept here
    /// until it is written.
    Device(Vec<u8>),
    /// A file in the directory of `target`, with a temporary name or none.
    File { target: PathBuf, temporary: Temporary },
}

#[derive(Debug)]
enum Temporary {
    #[cfg(target_os = "linux")]
    Unnamed(File),
    Named(tempfile::NamedTempFile),
}

/// Writes a complete file through `content` to the disk, in the directory of `path` but not under that name:
/// on Linux without any name, elsewhere under a temporary one.
///
/// A file that replaces another takes over its mode and its owner. A `path` that exists and is not a regular
/// file (`/dev/stdout`, a pipe) is written to directly by [`Prepared::publish`]. A symbolic link stays; the
/// file that it leads to is replaced.
///
/// # Errors
/// [`OutputError`] when the directory is missing or read-only, the disk is full, `content` failed, or `path`
/// is a file that must not be replaced: one that is read-only, or one with a second hard link, which would
/// still lead to the old text.
pub fn prepare<F>(path: &Path, content: F) -> Result<Prepared, OutputError>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let kind = prepare_kind(path, content);
    kind.map(|kind| Prepared { path: path.to_path_buf(), kind })
        .map_err(|reason| OutputError { path: path.to_path_buf(), reason })
}

fn prepare_kind<F>(path: &Path, content: F) -> io::Result<Kind>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let (target, replaced) = match fs::metadata(path) {
        Ok(existing) if existing.is_dir() => return Err(io::Error::other("it is a directory")),
        Ok(existing) if !existing.is_file() => {
            let mut text = Vec::new();
            content(&mut text)?;
            return Ok(Kind::Device(text));
        }
        Ok(existing) => {
            check_replaceable(&existing)?;
            (fs::canonicalize(path)?, Some(existing))
        }
        Err(_) => (path.to_path_buf(), None),
    };
    let directory = directory_of(&target);
    if !directory.is_dir() {
        return Err(io::Error::other(format!("folder {} does not exist", directory.display())));
    }
    #[cfg(target_os = "linux")]
    if let Some(file) = unnamed::create(directory) {
        fill(&file, replaced.as_ref(), content)?;
        return Ok(Kind::File { target, temporary: Temporary::Unnamed(file) });
    }
    let temporary = temporary_file(directory)?;
    fill(temporary.as_file(), replaced.as_ref(), content)?;
    Ok(Kind::File { target, temporary: Temporary::Named(temporary) })
}

impl Prepared {
    /// Gives the file its name, replacing any file of that name.
    ///
    /// # Errors
    /// [`OutputError`]; a previous file of that name is unchanged.
    pub fn publish(self) -> Result<(), OutputError> {
        let Self { path, kind } = self;
        let published = match kind {
            Kind::Device(text) => write_to_device(&path, &text),
            Kind::File { target, temporary } => temporary.replace(&target),
        };
        published.map_err(|reason| OutputError { path, reason })
    }

    /// Gives the file its name, which must not be taken.
    ///
    /// # Errors
    /// [`OutputError`], of the kind [`io::ErrorKind::AlreadyExists`] if the name is taken.
    pub fn publish_new(self) -> Result<(), OutputError> {
        let Self { path, kind } = self;
        let published = match kind {
            Kind::Device(text) => write_to_device(&path, &text),
            Kind::File { target, temporary } => temporary.name(&target),
        };
        published.map_err(|reason| OutputError { path, reason })
    }
}

impl Temporary {
    fn replace(self, target: &Path) -> io::Result<()> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => unnamed::replace(&file, target),
            Self::Named(file) => file.persist(target).map(drop).map_err(|error| error.error),
        }
    }

    fn name(self, target: &Path) -> io::Result<()> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => unnamed::name(&file, target),
            Self::Named(file) => file.persist_noclobber(target).map(drop).map_err(|error| error.error),
        }
    }
}

fn write_to_device(path: &Path, text: &[u8]) -> io::Result<()> {
    let mut device = File::options().write(true).open(path)?;
    device.write_all(text)?;
    device.flush()
}

fn directory_of(target: &Path) -> &Path {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Refuses to replace a file if that would defeat its owner's intent.
fn check_replaceable(existing: &Metadata) -> io::Result<()> {
    if existing.permissions().readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "it is read-only"));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        if existing.nlink() > 1 {
            let names = existing.nlink();
            return Err(io::Error::other(format!(
                "it has {names} names (hard links), and the others would keep the old text; write to another file"
            )));
        }
    }
    Ok(())
}

fn fill<F>(file: &File, replaced: Option<&Metadata>, content: F) -> io::Result<()>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let mut buffered = BufWriter::with_capacity(1 << 16, file);
    content(&mut buffered)?;
    buffered.flush()?;
    if let Some(replaced) = replaced {
        take_over(file, replaced)?;
    }
    // A rename can reach the disk before the data does; without this a power cut could leave an empty file.
    file.sync_all()
}

/// Gives a file the owner and the mode of the one that it will replace.
#[cfg(unix)]
fn take_over(file: &File, replaced: &Metadata) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt as _, fchown};
    let own = file.metadata()?;
    if (own.uid(), own.gid()) != (replaced.uid(), replaced.gid()) {
        fchown(file, Some(replaced.uid()), Some(replaced.gid())).map_err(|error| {
            io::Error::new(
                error.kind(),
                format!("it belongs to another user or group, which would be lost: {error}"),
            )
        })?;
    }
    // After the owner, because changing the owner clears set-user-id bits.
    file.set_permissions(replaced.permissions())
}

#[cfg(not(unix))]
fn take_over(_file: &File, _replaced: &Metadata) -> io::Result<()> {
    Ok(())
}

/// On Linux a file can be written before it has a name: if killed at any moment, the program leaves nothing
/// behind.
#[cfg(target_os = "linux")]
mod unnamed {
    use std::ffi::{OsStr, OsString};
    use std::fs::{self, File};
    use std::io;
    use std::os::fd::AsRawFd as _;
    use std::path::Path;

    use rustix::fs::{AtFlags, CWD, FlockOperation, Mode, OFlags};

    /// Creates a file without a name in the directory. `None` if the file system does not support that, or if
    /// `/proc`, through which the file is named, is missing.
    pub fn create(directory: &Path) -> Option<File> {
        let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
        // The mode of any new file, which the user's umask reduces.
        let mode = Mode::from_raw_mode(0o666);
        let file = File::from(rustix::fs::open(directory, flags, mode).ok()?);
        fs::exists(link(&file)).is_ok_and(|exists| exists).then_some(file)
    }

    fn link(file: &File) -> String {
        format!("/proc/self/fd/{}", file.as_raw_fd())
    }

    /// Gives the file a name that is not taken.
    pub fn name(file: &File, target: &Path) -> io::Result<()> {
        Ok(rustix::fs::linkat(CWD, link(file), CWD, target, AtFlags::SYMLINK_FOLLOW)?)
    }

    /// Gives the file a name, replacing any file of that name. The system names a file only if the name is
    /// free, so a name that is taken needs an intermediate one. The intermediate name is always the same: if
    /// killed at this moment, the program leaves it behind, and the next program that writes the file removes
    /// it.
    pub fn replace(file: &File, target: &Path) -> io::Result<()> {
        match name(file, target) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            named => return named,
        }
        // One program at a time: another that replaces this file would remove the intermediate name.
        let directory = File::open(super::directory_of(target))?;
        rustix::fs::flock(&directory, FlockOperation::LockExclusive)?;
        let between = target.with_file_name(between_name(target.file_name().unwrap_or_default()));
        match fs::remove_file(&between) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        name(file, &between)?;
        fs::rename(&between, target)
    }

    pub fn between_name(name: &OsStr) -> OsString {
        let mut between = OsString::from(".");
        between.push(name);
        between.push(".pylon-new");
        between
    }
}

fn temporary_file(directory: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pylon-");
    // Temporary files are private by default; an output file follows the user's umask.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(fs::Permissions::from_mode(0o666));
        builder.tempfile_in(directory)
    }
    #[cfg(not(unix))]
    builder.tempfile_in(directory)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn writes_the_whole_file_under_its_name_only() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out.csv");
        write_atomically(&path, |out| out.write_all(b"whole")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(directory.path()), ["out.csv"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_has_no_name_until_it_is_whole() {
        let directory = tempfile::tempdir().unwrap();
        if unnamed::create(directory.path()).is_none() {
            println!("skipped: the file system has no files without names");
            return;
        }
        for content in ["first", "second"] {
            let path = directory.path().join("out.csv");
            let before = names(directory.path());
            write_atomically(&path, |out| {
                out.write_all(content.as_bytes())?;
                out.flush()?;
                assert_eq!(names(directory.path()), before);
                Ok(())
            })
            .unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
            assert_eq!(names(directory.path()), ["out.csv"]);
        }
    }

    #[test]
    fn a_failure_midway_leaves_nothing_new_and_the_old_file_untouched() {
        let directory = tempfile::tempdir().unwrap();
        let fail = |out: &mut dyn Write| {
            out.write_all(&[b'x'; 1 << 17])?;
            Err(io::Error::other("disk full"))
        };
        let fresh = directory.path().join("fresh.csv");
        let message = write_atomically(&fresh, fail).unwrap_err().to_string();
        assert!(message.ends_with("fresh.csv: cannot be written: disk full"), "{message}");
        assert!(names(directory.path()).is_empty());

        let old = directory.path().join("old.csv");
        fs::write(&old, "old").unwrap();
        write_atomically(&old, fail).unwrap_err();
        assert_eq!(fs::read(&old).unwrap(), b"old");
        assert_eq!(names(directory.path()), ["old.csv"]);
    }

    #[test]
    fn a_missing_directory_is_an_error() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("no/such/out.csv");
        assert!(write_atomically(&path, |out| out.write_all(b"x")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn follows_links_and_leaves_devices_alone() {
        use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _, symlink};
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("file");
        let link = directory.path().join("link");
        fs::write(&file, "old").unwrap();
        symlink(&file, &link).unwrap();
        write_atomically(&link, |out| out.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");

        let pipe = directory.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        write_atomically(&pipe, |out| out.write_all(b"through")).unwrap();
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert_eq!(reader.join().unwrap(), b"through");

        // As any program's output: readable by others if the umask permits it.
        let reference = directory.path().join("reference");
        fs::write(&reference, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&file), mode(&reference));
    }

    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_mode_and_owner() {
        use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, chown};
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("ours.toml");
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        let may_give_away = chown(&file, Some(12_345), Some(54_321)).is_ok();
        if !may_give_away {
            println!("skipped: another owner (only root may give files away)");
        }
        let before = fs::metadata(&file).unwrap();
        write_atomically(&file, |out| out.write_all(b"new")).unwrap();
        let after = fs::metadata(&file).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(after.permissions().mode() & 0o7777, 0o640);
        assert_eq!((after.uid(), after.gid()), (before.uid(), before.gid()));
    }

    #[cfg(unix)]
    #[test]
    fn a_read_only_file_and_one_with_two_names_are_not_replaced() {
        use std::os::unix::fs::PermissionsExt as _;
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("ours.toml");
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o444)).unwrap();
        let refused = write_atomically(&file, |out| out.write_all(b"new")).unwrap_err().to_string();
        assert!(refused.ends_with("ours.toml: cannot be written: it is read-only"), "{refused}");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
        fs::hard_link(&file, directory.path().join("theirs.toml")).unwrap();
        let refused = write_atomically(&file, |out| out.write_all(b"new")).unwrap_err().to_string();
        assert!(refused.contains("it has 2 names (hard links)"), "{refused}");
        assert_eq!(fs::read(&file).unwrap(), b"old");
        assert_eq!(names(directory.path()), ["ours.toml", "theirs.toml"]);
    }

    #[test]
    fn what_is_prepared_and_dropped_was_never_there() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out.csv");
        drop(prepare(&path, |out| out.write_all(b"x")).unwrap());
        assert!(names(directory.path()).is_empty());
    }

    #[test]
    fn a_new_file_takes_no_name_that_another_was_given_meanwhile() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("ours.toml");
        let [first, second] =
            ["first", "second"].map(|text| prepare(&path, |out| out.write_all(text.as_bytes())).unwrap());
        first.publish_new().unwrap();
        let refused = second.publish_new().unwrap_err();
        assert_eq!(refused.reason.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(names(directory.path()), ["ours.toml"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_a_killed_program_left_is_taken_away_by_the_next() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out.csv");
        fs::write(&path, "old").unwrap();
        fs::write(directory.path().join(unnamed::between_name(path.file_name().unwrap())), "left").unwrap();
        write_atomically(&path, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(directory.path()), ["out.csv"]);
    }
}
