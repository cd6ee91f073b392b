//! What to do with a log next.

/// Commands to go on with, to be pasted into a shell.
pub(super) fn next(file: &str, is_usable: bool) -> Vec<String> {
    let file = quoted(file);
    if !is_usable {
        return vec![format!("pylon import {file} -o flight.csv")];
    }
    vec![
        format!("pylon compare {file}"),
        format!("pylon diagnose {file}"),
        format!("pylon report {file} -o report.html"),
        format!("pylon import {file} -o flight.csv"),
    ]
}

/// A file's name as a shell takes it.
fn quoted(file: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "/._-+,:@%".contains(letter);
    let file = if file.starts_with('-') { format!("./{file}") } else { file.to_owned() };
    if file.chars().all(is_plain) { file } else { format!("'{}'", file.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_for_a_shell() {
        assert_eq!(quoted("logs/a-1.igc"), "logs/a-1.igc");
        assert_eq!(quoted("my log.igc"), "'my log.igc'");
        assert_eq!(quoted("it's.igc"), r"'it'\''s.igc'");
        assert_eq!(quoted("-o.igc"), "./-o.igc");
    }
}
