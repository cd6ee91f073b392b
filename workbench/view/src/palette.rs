//! One colour for each role, wherever it is drawn.

use crate::chart::Role;

/// Appearance of a role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ink {
    /// Colour of lines on white paper: red, green, blue.
    pub line: [u8; 3],
    /// Colour of areas on white paper.
    pub area: [u8; 3],
    /// Width of curves on paper, half CSS pixels.
    pub width: i32,
    /// Colour in a page on a light background, in CSS notation. Screens use Okabe and Ito's colours, which
    /// colour-blind people can distinguish.
    pub light: &'static str,
    /// Colour in a page on a dark background.
    pub dark: &'static str,
}

impl Ink {
    const fn new(line: [u8; 3], area: [u8; 3], width: i32, light: &'static str, dark: &'static str) -> Self {
        Self { line, area, width, light, dark }
    }
}

impl Role {
    /// All roles.
    pub const ALL: [Self; 11] = [
        Self::Measured,
        Self::Modelled,
        Self::Residual,
        Self::Average,
        Self::Effect,
        Self::Bound,
        Self::Sigma,
        Self::Doubtful,
        Self::Untrustworthy,
        Self::Event,
        Self::Shade,
    ];

    /// Its name in JSON and in the variables of a page's style.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Modelled => "modelled",
            Self::Residual => "residual",
            Self::Average => "average",
            Self::Effect => "effect",
            Self::Bound => "bound",
            Self::Sigma => "sigma",
            Self::Doubtful => "doubtful",
            Self::Untrustworthy => "untrustworthy",
            Self::Event => "event",
            Self::Shade => "shade",
        }
    }

    /// Its appearance.
    #[must_use]
    pub const fn ink(self) -> Ink {
        const BLUE: [u8; 3] = [0, 90, 160];
        const LIGHT_BLUE: [u8; 3] = [95, 155, 210];
        const PALE_BLUE: [u8; 3] = [205, 224, 241];
        const GREY: [u8; 3] = [120; 3];
        const PALE_GREY: [u8; 3] = [238; 3];
        const MAGENTA: [u8; 3] = [214, 0, 170];
        const PALE_MAGENTA: [u8; 3] = [247, 214, 240];
        match self {
            Self::Measured => Ink::new(GREY, PALE_GREY, 2, "#0072b2", "#56b4e9"),
            Self::Modelled => Ink::new(BLUE, PALE_BLUE, 3, "#c4530a", "#ffab5e"),
            // A dense series fills its band.
            Self::Residual => Ink::new(LIGHT_BLUE, LIGHT_BLUE, 2, "#3d8fc9", "#56b4e9"),
            Self::Average => Ink::new([0, 150, 60], [204, 234, 216], 3, "#00734f", "#33d6a4"),
            Self::Effect => Ink::new(BLUE, PALE_BLUE, 2, "#005a9e", "#7cc4ff"),
            Self::Bound => Ink::new(GREY, PALE_GREY, 2, "#2b333b", "#d5dde4"),
            // Dark enough to be visible over a dense blue series.
            Self::Sigma => Ink::new([150, 45, 0], [240, 224, 217], 2, "#2b333b", "#d5dde4"),
            Self::Doubtful => Ink::new(MAGENTA, PALE_MAGENTA, 2, "#8a6d00", "#ffe24a"),
            Self::Untrustworthy => Ink::new([193, 18, 31], [247, 219, 221], 2, "#c1121f", "#ff5a5f"),
            Self::Event => Ink::new(MAGENTA, PALE_MAGENTA, 2, "#55606b", "#b7c2cc"),
            Self::Shade => Ink::new([230, 159, 0], [252, 241, 217], 2, "#e69f00", "#e6b53c"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_role_has_the_same_name_in_json_and_in_the_style() {
        let style = crate::page::style();
        for role in Role::ALL {
            let name = role.name();
            assert_eq!(serde_json::to_string(&role).unwrap(), format!("\"{name}\""));
            assert_eq!(style.matches(&format!("--{name}: ")).count(), 1, "{style}");
        }
    }

    #[test]
    fn roles_that_meet_in_one_diagram_differ() {
        use Role::{Average, Bound, Doubtful, Measured, Modelled, Residual, Sigma, Untrustworthy};
        for together in [
            &[Measured, Modelled][..],
            &[Residual, Sigma],
            &[Residual, Average, Bound, Doubtful, Untrustworthy],
        ] {
            let lines: std::collections::BTreeSet<_> = together.iter().map(|role| role.ink().line).collect();
            assert_eq!(lines.len(), together.len(), "{together:?}");
        }
    }
}
