//! Removes images of models that are no longer flown.

use std::fs;
use std::io;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Number of newest files that are kept, an image, its key and its model's source each: a run of all tests
/// makes 125, and finds them when it is run again.
const KEPT: usize = 240;
/// A file younger than this is always kept: its image may be about to fly.
const YOUNG: Duration = Duration::from_secs(3_600);

/// Removes all but the newest files of a folder.
///
/// # Errors
/// The folder cannot be read. A file that cannot be removed stays.
pub fn prune(folder: &Path, now: SystemTime) -> io::Result<()> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let metadata = entry.metadata()?;
        if metadata.is_file() {
            files.push((metadata.modified()?, entry.path()));
        }
    }
    files.sort();
    let older = files.len().saturating_sub(KEPT);
    for (modified, file) in files.into_iter().take(older) {
        if now.duration_since(modified).is_ok_and(|age| age > YOUNG) {
            // A file that is open elsewhere or may not be removed stays until the next build.
            let _ = fs::remove_file(file);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    #[test]
    fn keeps_the_newest_and_the_young() {
        let folder = tempfile::tempdir().unwrap();
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
        let make = |name: &str, age_s: u64| {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_modified(now - Duration::from_secs(age_s)).unwrap();
        };
        let names = || fs::read_dir(folder.path()).unwrap().count();
        for index in 0..300 {
            make(&format!("old-{index:03}"), 100_000 + index);
        }
        prune(folder.path(), now).unwrap();
        assert_eq!(names(), KEPT);
        assert!(folder.path().join("old-000").exists() && !folder.path().join("old-299").exists());

        for index in 0..300 {
            make(&format!("young-{index:03}"), index);
        }
        prune(folder.path(), now).unwrap();
        assert_eq!(names(), 300);
        assert!(folder.path().join("young-299").exists() && !folder.path().join("old-000").exists());
    }
}
