//! The model file that a studio may write.

use std::fs;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};

use model::Model;
use pylon::output_file::write_atomically;
use serde::Serialize;

use crate::cli::failure::Failure;
use crate::cli::model_lock::lock_model;

/// A model file.
#[derive(Clone, Debug)]
pub struct ModelFile {
    path: PathBuf,
}

/// A model and the version of its file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ServedModel {
    /// The model.
    pub model: NamedText,
    /// Identifies this version of the file.
    pub version: String,
}

/// A model's name and text, as served to the page.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NamedText {
    /// The file's name, without its folder.
    pub name: String,
    /// Its TOML.
    pub text: String,
}

/// The outcome of a request to write.
#[derive(Debug)]
pub enum Saved {
    /// It was written.
    Written(ServedModel),
    /// The file has changed since the page read it: nothing was written.
    Changed(ServedModel),
    /// The text is not a valid model: nothing was written.
    NoModel(String),
}

impl ModelFile {
    /// The file at a path.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_path_buf() }
    }

    /// Reads the model from its file.
    pub fn read(&self) -> Result<ServedModel, Failure> {
        let text = fs::read_to_string(&self.path).map_err(|error| {
            let hint = if error.kind() == std::io::ErrorKind::NotFound {
                format!(" (an empty file is a model: touch {})", self.path.display())
            } else {
                String::new()
            };
            Failure::input(format!("{}: cannot be read: {error}{hint}", self.path.display()))
        })?;
        Ok(self.served(text))
    }

    fn served(&self, text: String) -> ServedModel {
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        let name = self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned();
        ServedModel { model: NamedText { name, text }, version: format!("{:016x}", hasher.finish()) }
    }

    /// Replaces the file's text if it still has that version and no other program is changing it.
    pub fn save(&self, text: String, version: &str) -> Result<Saved, Failure> {
        if let Err(error) = Model::parse(&text) {
            return Ok(Saved::NoModel(error.to_string()));
        }
        let _lock = lock_model(&self.path)?;
        let now = self.read()?;
        if now.version != version {
            return Ok(Saved::Changed(now));
        }
        write_atomically(&self.path, |out| out.write_all(text.as_bytes()))?;
        Ok(Saved::Written(self.served(text)))
    }
}
