//! What to do with a log next.

/// Commands to continue with, to be pasted into a shell. `import` refuses a file that is already a flight's
/// CSV.
pub(super) fn next(file: &str, is_usable: bool, is_flight: bool) -> Vec<String> {
    let file = quoted(file);
    let analysis = ["pylon compare", "pylon diagnose"].map(|command| format!("{command} {file}"));
    let analysis = analysis.into_iter().chain([format!("pylon report {file} -o report.html")]);
    let import = (!is_flight).then(|| format!("pylon import {file} -o flight.csv"));
    analysis.filter(|_| is_usable).chain(import).collect()
}

/// A file's name, quoted for a shell.
#[must_use]
pub fn quoted(file: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "/._-+,:@%".contains(letter);
    let file = if file.starts_with('-') { format!("./{file}") } else { file.to_owned() };
    if file.chars().all(is_plain) { file } else { format!("'{}'", file.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_a_flight_already_is_not_to_be_imported() {
        assert_eq!(next("a.csv", false, true), Vec::<String>::new());
        assert_eq!(next("a.csv", true, true).len(), 3);
        assert_eq!(next("a.igc", false, false), ["pylon import a.igc -o flight.csv"]);
        assert_eq!(next("a.igc", true, false)[3], "pylon import a.igc -o flight.csv");
    }

    #[test]
    fn names_are_quoted_for_a_shell() {
        assert_eq!(quoted("logs/a-1.igc"), "logs/a-1.igc");
        assert_eq!(quoted("my log.igc"), "'my log.igc'");
        assert_eq!(quoted("it's.igc"), r"'it'\''s.igc'");
        assert_eq!(quoted("-o.igc"), "./-o.igc");
    }
}
