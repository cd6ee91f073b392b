//! Lists for users.

/// How many kinds of unused messages are named.
const NAMED: usize = 8;

/// Lists the most frequent kinds, each with its count, and the number of other kinds; `None` for an empty
/// list.
pub fn most_of(mut kinds: Vec<(String, usize)>) -> Option<String> {
    kinds.sort_by(|one, other| (other.1, &one.0).cmp(&(one.1, &other.0)));
    let rest = kinds.len().saturating_sub(NAMED);
    let named: Vec<String> =
        kinds.iter().take(NAMED).map(|(name, count)| format!("{name} ({count})")).collect();
    let more = if rest > 0 { format!(" and {rest} more kinds") } else { String::new() };
    (!named.is_empty()).then(|| named.join(", ") + &more)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_most_and_counts_the_rest() {
        let kinds = |count: usize| (0..count).map(|k| (format!("K{k}"), k)).collect::<Vec<_>>();
        assert_eq!(most_of(Vec::new()), None);
        assert_eq!(most_of(kinds(2)).unwrap(), "K1 (1), K0 (0)");
        assert!(most_of(kinds(10)).unwrap().ends_with("K2 (2) and 2 more kinds"));
    }
}
