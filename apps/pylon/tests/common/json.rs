//! The program's JSON, checked against its schema and its type.

use std::path::Path;

use pylon::results::schemas;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The result of a command that must succeed.
pub fn checked<T: Serialize + DeserializeOwned>(command: &str, directory: &Path, arguments: &[&str]) -> T {
    let all = [&[command], arguments, &["--json"]].concat();
    read(command, &super::program::stdout(directory, &all))
}

/// Reads a command's JSON into its type. It must match the command's schema, and what the type writes.
pub fn read<T: Serialize + DeserializeOwned>(command: &str, json: &str) -> T {
    let (_, schema) = schemas().into_iter().find(|(name, _)| *name == command).unwrap();
    let validator = jsonschema::validator_for(schema.as_value()).unwrap();
    let value: serde_json::Value = serde_json::from_str(json).unwrap();
    let errors: Vec<String> =
        validator.iter_errors(&value).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert!(errors.is_empty(), "{command}: {}", errors.join("\n"));
    let result: T = serde_json::from_str(json).unwrap();
    assert_eq!(serde_json::to_string_pretty(&result).unwrap() + "\n", json, "{command}");
    result
}
