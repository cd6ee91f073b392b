//! Makes text from files safe to print: a header may contain escape sequences that move a terminal's cursor
//! or set its title.

use std::borrow::Cow;

/// The text with control characters escaped, except line breaks and tabs.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    spelled_out(text, |letter| letter.is_control() && !matches!(letter, '\n' | '\t'))
}

/// The text with every control character escaped.
pub(super) fn one_line(text: &str) -> Cow<'_, str> {
    spelled_out(text, char::is_control)
}

fn spelled_out(text: &str, is_spelled: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_spelled) {
        return Cow::Borrowed(text);
    }
    let spelled = text.chars().fold(String::with_capacity(text.len()), |mut spelled, letter| {
        if is_spelled(letter) {
            spelled.extend(letter.escape_default());
        } else {
            spelled.push(letter);
        }
        spelled
    });
    Cow::Owned(spelled)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_control_characters_are_spelled_out() {
        assert_eq!(printable("Ångström ± 1\n\tok"), "Ångström ± 1\n\tok");
        assert_eq!(printable("a\x1b]0;title\x07b\u{9b}2J\r"), "a\\u{1b}]0;title\\u{7}b\\u{9b}2J\\r");
        assert_eq!(one_line("a\nb\tc ±"), "a\\nb\\tc ±");
    }
}
