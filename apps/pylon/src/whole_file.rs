//! A file's bytes, read in as many threads as there are cores: for a long flight half of the time is the
//! kernel's copying.

use std::io;
use std::path::Path;

/// Least number of bytes for which a thread is worth starting.
#[cfg(unix)]
const SHORTEST_PART: usize = 4 << 20;

/// Limit on the memory that importing a file takes, in multiples of its size.
const TIMES: u64 = 3;

/// All bytes of a file.
///
/// # Errors
/// As [`std::fs::read`]; also for a file that does not fit into memory, before any of it is read.
#[cfg(unix)]
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    use std::fs::File;
    use std::io::Read as _;
    use std::os::unix::fs::FileExt as _;

    use executor::Executor as _;

    use crate::threads::Threads;

    let mut file = File::open(path)?;
    let metadata = file.metadata()?;
    check_fits(metadata.len(), available())?;
    let length = usize::try_from(metadata.len()).map_err(io::Error::other)?;
    let threads = Threads.width().min(length / SHORTEST_PART);
    if !metadata.is_file() || threads < 2 {
        let mut bytes = Vec::with_capacity(length);
        file.read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    let mut bytes = vec![0; length];
    let part = length.div_ceil(threads);
    let parts = bytes.chunks_mut(part).enumerate();
    let read = parts.map(|(index, chunk)| {
        let file = &file;
        move || file.read_exact_at(chunk, (index * part) as u64)
    });
    executor::map(&Threads, read).into_iter().collect::<io::Result<()>>()?;
    Ok(bytes)
}

/// Refuses a file too large for memory: it would end the whole program, and with it all other flights of a
/// batch.
fn check_fits(length: u64, available: Option<u64>) -> io::Result<()> {
    let Some(available) = available.filter(|available| length.saturating_mul(TIMES) > *available) else {
        return Ok(());
    };
    let gigabytes = |bytes: u64| bytes as f64 / 1e9;
    Err(io::Error::new(
        io::ErrorKind::OutOfMemory,
        format!(
            "it has {:.1} GB and needs up to {TIMES} times that in memory, but {:.1} GB are free: split it into parts",
            gigabytes(length),
            gigabytes(available)
        ),
    ))
}

/// Memory available without swapping, if the system reports it.
fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok()?.checked_mul(1024)
}

/// All bytes of a file.
///
/// # Errors
/// As [`std::fs::read`]; also for a file that does not fit into memory, before any of it is read.
#[cfg(not(unix))]
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    check_fits(std::fs::metadata(path)?.len(), available())?;
    std::fs::read(path)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn gives_what_the_standard_library_gives() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        for length in [0, 1, 3 * SHORTEST_PART + 7] {
            let bytes: Vec<u8> = (0..length).map(|index| (index % 251) as u8).collect();
            std::fs::write(&path, &bytes).unwrap();
            assert!(read(&path).unwrap() == bytes, "{length}");
        }
        assert_eq!(read(directory.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        assert_eq!(read(&path.join("none")).unwrap_err().kind(), io::ErrorKind::NotADirectory);
    }

    #[test]
    fn a_file_that_does_not_fit_is_not_begun() {
        assert!(check_fits(1 << 20, Some(3 << 20)).is_ok() && check_fits(1 << 40, None).is_ok());
        let error = check_fits(8_000_000_000, Some(20_000_000_000)).unwrap_err().to_string();
        assert_eq!(
            error,
            "it has 8.0 GB and needs up to 3 times that in memory, but 20.0 GB are free: split it into parts"
        );
    }

    #[test]
    fn reads_a_pipe() {
        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let writer = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::write(pipe, "through").unwrap()
        });
        assert_eq!(read(&pipe).unwrap(), b"through");
        writer.join().unwrap();
    }
}
