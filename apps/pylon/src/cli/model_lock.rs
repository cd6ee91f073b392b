//! A lock, so that only one program at a time changes a model.

use std::fs::{File, TryLockError};
use std::path::Path;

use same_file::Handle;

use super::failure::Failure;
use super::progress::while_busy;

/// While this is held, no other program changes the model.
#[derive(Debug)]
pub struct ModelLock {
    /// The locked file; closing it releases the lock.
    _file: File,
}

/// Waits until no other program is changing the model at `path`, then locks it. Anything read from the model
/// earlier must be read again.
///
/// The lock is on the file itself, which every change replaces. If the file was replaced while this program
/// waited, the new file of that name is locked instead.
pub fn lock_model(path: &Path) -> Result<ModelLock, Failure> {
    let in_file =
        |error: std::io::Error| Failure::input(format!("{}: cannot be locked: {error}", path.display()));
    loop {
        let file = File::open(path).map_err(in_file)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                while_busy("waiting for another pylon that is changing this model", || file.lock())
                    .map_err(in_file)?;
            }
            Err(TryLockError::Error(error)) => return Err(in_file(error)),
        }
        let locked = Handle::from_file(file.try_clone().map_err(in_file)?).map_err(in_file)?;
        if Handle::from_path(path).is_ok_and(|now| now == locked) {
            return Ok(ModelLock { _file: file });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::Barrier;

    use pylon::output_file::write_atomically;

    use super::*;

    /// As `add` does it: read, change, replace. Without the lock, or with a lock on the replaced file,
    /// changes are lost.
    #[test]
    fn of_25_changes_at_once_none_is_lost() {
        const CHANGES: usize = 25;
        let directory = tempfile::tempdir().unwrap();
        let model = directory.path().join("ours.toml");
        fs::write(&model, "").unwrap();
        let start = Barrier::new(CHANGES);
        std::thread::scope(|scope| {
            for change in 0..CHANGES {
                let (model, start) = (&model, &start);
                scope.spawn(move || {
                    start.wait();
                    let _lock = lock_model(model).unwrap();
                    let text = fs::read_to_string(model).unwrap();
                    std::thread::yield_now();
                    write_atomically(model, |out| writeln!(out, "{text}# {change}")).unwrap();
                });
            }
        });
        let text = fs::read_to_string(&model).unwrap();
        assert_eq!(text.lines().count(), CHANGES, "{text}");
        (0..CHANGES).for_each(|change| assert!(text.contains(&format!("# {change}\n")), "{change}: {text}"));
    }
}
