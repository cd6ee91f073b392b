//! Errors as numbers beside bars, for comparison at a glance.

use maud::{Markup, html};

use crate::compare::text::number::metres;

/// One error as a bar; `greatest` is the full length.
pub(super) fn bar(value: f64, greatest: f64) -> Markup {
    html! {
        div.bar.after {
            span.track { span.length style=(format!("width: {:.1}%", share(value, greatest))) {} }
            span.value { (metres(Some(value))) }
        }
    }
}

/// A value as per cent of the greatest.
pub(super) fn share(value: f64, greatest: f64) -> f64 {
    if greatest > 0.0 { 100.0 * value / greatest } else { 0.0 }
}

/// Errors before and after, each with its label, as bars; `greatest` is the full length.
pub(super) fn bars(before: (&str, Option<f64>), after: (&str, Option<f64>), greatest: f64) -> Markup {
    if before.1.is_none() && after.1.is_none() {
        return html! { "-" };
    }
    html! {
        @for (kind, (word, value)) in [("before", before), ("after", after)] {
            @if let Some(value) = value {
                div class=(format!("bar {kind}")) {
                    span.track { span.length style=(format!("width: {:.1}%", share(value, greatest))) {} }
                    span.value { (word) " " (metres(Some(value))) }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_shares_of_the_greatest() {
        let text = bars(("without", Some(4.0)), ("with", Some(1.0)), 8.0).into_string();
        assert!(text.contains("width: 50.0%") && text.contains("width: 12.5%"), "{text}");
        assert!(text.contains("without 4.00 m") && text.contains("with 1.00 m"), "{text}");
        assert_eq!(bars(("without", None), ("with", None), 0.0).into_string(), "-");
        assert!(bars(("without", Some(0.0)), ("with", None), 0.0).into_string().contains("width: 0.0%"));
    }
}
