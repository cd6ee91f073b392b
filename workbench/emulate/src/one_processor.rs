//! Runs a program whose threads take turns on one processor.
//!
//! QEMU's two threads hand over to each other some fifty times a tick, and waking one that sleeps on another
//! processor takes longer than the work it then does. On one processor a flight takes little more than half
//! the time and leaves the others free. The results do not change by a bit: where this is not possible, the
//! program runs wherever the system likes.

use std::fs::File;
use std::io;
use std::path::Path;
use std::process::{Child, Command};

/// A processor reserved for one of our programs, until this is dropped or the process ends.
#[derive(Debug)]
pub struct Processor(#[expect(dead_code, reason = "a lock is there to be held")] File);

/// Starts a program on one of the processors that this thread may use: on one without a program that was
/// started this way with the same `folder`, in this process or another; else on this thread's current one.
///
/// # Errors
/// The program cannot be started.
#[cfg(target_os = "linux")]
pub fn spawn(command: &mut Command, folder: &Path) -> io::Result<(Child, Option<Processor>)> {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

    let Ok(allowed) = sched_getaffinity(None) else { return Ok((command.spawn()?, None)) };
    let (number, processor) =
        match claim(folder, (0..CpuSet::MAX_CPU).filter(|number| allowed.is_set(*number))) {
            Some((number, processor)) => (number, Some(processor)),
            None => (sched_getcpu(), None),
        };
    let mut one = CpuSet::new();
    one.set(number);
    // A child inherits the affinity of the thread that starts it; no other thread of ours is affected.
    let is_kept = sched_setaffinity(None, &one).is_ok();
    let child = command.spawn();
    if is_kept {
        // Restores what was allowed before, which is not refused.
        let _ = sched_setaffinity(None, &allowed);
    }
    Ok((child?, processor))
}

/// Starts a program.
///
/// # Errors
/// The program cannot be started.
#[cfg(not(target_os = "linux"))]
pub fn spawn(command: &mut Command, _folder: &Path) -> io::Result<(Child, Option<Processor>)> {
    Ok((command.spawn()?, None))
}

/// The first of these processors that is not claimed, and the claim; `None` where a claim cannot be kept in
/// the folder.
#[cfg(target_os = "linux")]
fn claim(folder: &Path, processors: impl Iterator<Item = usize>) -> Option<(usize, Processor)> {
    for number in processors {
        let lock = File::create(folder.join(format!("processor-{number}.lock"))).ok()?;
        if lock.try_lock().is_ok() {
            return Some((number, Processor(lock)));
        }
    }
    None
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use rustix::thread::sched_getaffinity;
    use std::process::Stdio;

    #[test]
    fn a_processor_is_claimed_once_until_it_is_given_back() {
        let folder = tempfile::tempdir().unwrap();
        let (first, held) = claim(folder.path(), [3, 5].into_iter()).unwrap();
        let (second, _also_held) = claim(folder.path(), [3, 5].into_iter()).unwrap();
        assert_eq!((first, second), (3, 5));
        assert!(claim(folder.path(), [3, 5].into_iter()).is_none());
        drop(held);
        assert_eq!(claim(folder.path(), [3, 5].into_iter()).unwrap().0, 3);
        assert!(claim(&folder.path().join("missing"), [3].into_iter()).is_none());
    }

    /// With a folder to keep claims in, and without: the child may use one processor, and this thread all
    /// that it could before.
    #[test]
    fn a_child_is_kept_on_one_processor_and_this_thread_on_none() {
        let folder = tempfile::tempdir().unwrap();
        let before = sched_getaffinity(None).unwrap();
        for folder in [folder.path(), &folder.path().join("missing")] {
            let mut command = Command::new("sh");
            command.args(["-c", "grep Cpus_allowed_list /proc/self/status"]).stdout(Stdio::piped());
            let (child, _processor) = spawn(&mut command, folder).unwrap();
            let said = String::from_utf8(child.wait_with_output().unwrap().stdout).unwrap();
            let list = said.trim().rsplit('\t').next().unwrap();
            assert!(list.parse::<usize>().is_ok(), "{said}");
            assert_eq!(sched_getaffinity(None).unwrap(), before);
        }
    }

    #[test]
    fn a_missing_program_is_that_and_leaves_this_thread_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let before = sched_getaffinity(None).unwrap();
        let error = spawn(&mut Command::new("no-such-program"), folder.path()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert_eq!(sched_getaffinity(None).unwrap(), before);
    }
}
