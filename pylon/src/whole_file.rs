//! A file's bytes, read in as many threads as there are cores: of a long flight half of the time goes into
//! the kernel's copying.

use std::io;
use std::path::Path;

/// A thread is worth starting for this many bytes.
#[cfg(unix)]
const SHORTEST_PART: usize = 4 << 20;

/// All bytes of a file.
///
/// # Errors
/// As [`std::fs::read`].
#[cfg(unix)]
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    use std::fs::File;
    use std::io::Read as _;
    use std::os::unix::fs::FileExt as _;
    use std::thread;

    let mut file = File::open(path)?;
    let metadata = file.metadata()?;
    let length = usize::try_from(metadata.len()).map_err(io::Error::other)?;
    let threads = thread::available_parallelism().map_or(1, usize::from).min(length / SHORTEST_PART);
    if !metadata.is_file() || threads < 2 {
        let mut bytes = Vec::with_capacity(length);
        file.read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    let mut bytes = vec![0; length];
    let part = length.div_ceil(threads);
    thread::scope(|scope| {
        let readers: Vec<_> = bytes
            .chunks_mut(part)
            .enumerate()
            .map(|(index, chunk)| {
                let file = &file;
                scope.spawn(move || file.read_exact_at(chunk, (index * part) as u64))
            })
            .collect();
        readers
            .into_iter()
            .try_for_each(|reader| reader.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })?;
    Ok(bytes)
}

/// All bytes of a file.
///
/// # Errors
/// As [`std::fs::read`].
#[cfg(not(unix))]
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
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
