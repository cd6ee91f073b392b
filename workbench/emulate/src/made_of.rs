//! Whether an existing image was built from the current sources: then it need not be linked again, which
//! takes some twenty seconds whenever another model was built in between.

use std::fs::{self, File};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What the firmware is built from, in the checkout: its crates and cargo's settings for them. Other crates
/// do not matter.
const SOURCES: &[&str] = &[
    ".cargo",
    "Cargo.lock",
    "Cargo.toml",
    "bench",
    "firmware",
    "kf-core",
    "memory.x",
    "model",
    "onboard",
    "rust-toolchain.toml",
];

/// A hash over those files (names and bytes) and over `settings`: the compiler, the options, the model's
/// source.
///
/// # Errors
/// A file cannot be read.
pub fn key(root: &Path, settings: &[&str]) -> io::Result<String> {
    let mut hasher = DefaultHasher::new();
    settings.hash(&mut hasher);
    for source in SOURCES {
        hash_into(&mut hasher, root, &root.join(source))?;
    }
    Ok(format!("{:016x}", hasher.finish()))
}

fn hash_into(hasher: &mut DefaultHasher, root: &Path, path: &Path) -> io::Result<()> {
    let name = path.strip_prefix(root).unwrap_or(path);
    if path.is_dir() {
        let mut entries: Vec<PathBuf> =
            fs::read_dir(path)?.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<_>>()?;
        entries.sort();
        return entries.iter().try_for_each(|entry| hash_into(hasher, root, entry));
    }
    name.hash(hasher);
    match fs::read(path) {
        Ok(bytes) => bytes.hash(hasher),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    Ok(())
}

fn key_file(image: &Path) -> PathBuf {
    image.with_extension("made-of")
}

/// Whether this image has that key. If so it is marked as just used, so that it is not pruned.
pub fn is_current(image: &Path, key: &str) -> bool {
    let file = key_file(image);
    let current = image.is_file() && fs::read_to_string(&file).is_ok_and(|found| found == key);
    if current {
        for used in [image, &file] {
            // If the time cannot be set, the image is only pruned sooner.
            let _ = File::open(used).and_then(|file| file.set_modified(SystemTime::now()));
        }
    }
    current
}

/// Call this before the image is replaced: until [`keep`] it has no key.
///
/// # Errors
/// The old key cannot be removed.
pub fn forget(image: &Path) -> io::Result<()> {
    match fs::remove_file(key_file(image)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Stores the key, once the image is in its place.
///
/// # Errors
/// It cannot be written.
pub fn keep(image: &Path, key: &str) -> io::Result<()> {
    fs::write(key_file(image), key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_source_a_new_file_and_another_setting_each_make_another_key() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        fs::create_dir_all(at("kf-core/src")).unwrap();
        fs::create_dir_all(at("apps")).unwrap();
        fs::write(at("kf-core/src/lib.rs"), "one").unwrap();
        let first = key(root.path(), &["rustc 1"]).unwrap();
        assert_eq!(key(root.path(), &["rustc 1"]).unwrap(), first);
        fs::write(at("apps/other.rs"), "not the firmware's").unwrap();
        assert_eq!(key(root.path(), &["rustc 1"]).unwrap(), first);
        assert_ne!(key(root.path(), &["rustc 2"]).unwrap(), first);
        fs::write(at("kf-core/src/new.rs"), "").unwrap();
        let second = key(root.path(), &["rustc 1"]).unwrap();
        assert_ne!(second, first);
        fs::write(at("kf-core/src/lib.rs"), "two").unwrap();
        assert_ne!(key(root.path(), &["rustc 1"]).unwrap(), second);
    }

    #[test]
    fn an_image_is_current_only_with_its_own_key() {
        let folder = tempfile::tempdir().unwrap();
        let image = folder.path().join("flight.elf");
        assert!(!is_current(&image, "a"));
        fs::write(&image, "image").unwrap();
        assert!(!is_current(&image, "a"));
        keep(&image, "a").unwrap();
        assert!(is_current(&image, "a") && !is_current(&image, "b"));
        forget(&image).unwrap();
        assert!(!is_current(&image, "a"));
        forget(&image).unwrap();
    }
}
