//! Detects the terminal's colour depth from the environment.

/// Colour depth of a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorDepth {
    /// All of them.
    True,
    /// 256.
    Indexed,
    /// The sixteen that every terminal with colours has.
    Sixteen,
    /// None: `NO_COLOR` is set, or the terminal has none.
    None,
}

/// Terminals that show 256 colours at least, and whose `TERM` does not say so.
const CAPABLE: [&str; 9] = [
    "alacritty",
    "contour",
    "foot",
    "ghostty",
    "iterm",
    "kitty",
    "mlterm",
    "rio",
    "wezterm",
];

impl ColorDepth {
    /// Every depth with its name, the most colours first.
    pub const NAMED: [(&str, Self); 4] = [
        ("true", Self::True),
        ("256", Self::Indexed),
        ("16", Self::Sixteen),
        ("none", Self::None),
    ];

    /// Detects the depth from the environment.
    #[must_use]
    pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Self {
        let says = |name: &str| env(name).filter(|v| !v.is_empty());
        if says("NO_COLOR").is_some() {
            return Self::None;
        }
        if matches!(says("COLORTERM").as_deref(), Some("truecolor" | "24bit")) {
            return Self::True;
        }
        // Windows Terminal has no TERM.
        if says("WT_SESSION").is_some() {
            return Self::True;
        }
        let term = says("TERM").unwrap_or_default();
        if term.ends_with("-direct") {
            Self::True
        } else if term.contains("256color") || CAPABLE.iter().any(|name| term.contains(name)) {
            Self::Indexed
        } else if term == "dumb"
            || term.ends_with("-m")
            || term.starts_with("vt1")
            || term.starts_with("vt2")
        {
            Self::None
        } else {
            Self::Sixteen
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_says() {
        let of = |pairs: &[(&str, &str)]| {
            ColorDepth::of_environment(|name| {
                let pair = pairs.iter().find(|(n, _)| *n == name);
                pair.map(|(_, value)| (*value).to_string())
            })
        };
        assert_eq!(
            of(&[("NO_COLOR", "1"), ("COLORTERM", "truecolor")]),
            ColorDepth::None
        );
        assert_eq!(
            of(&[("NO_COLOR", ""), ("COLORTERM", "truecolor")]),
            ColorDepth::True
        );
        for (term, depth) in [
            ("xterm-256color", ColorDepth::Indexed),
            ("xterm-kitty", ColorDepth::Indexed),
            ("xterm-direct", ColorDepth::True),
            ("xterm", ColorDepth::Sixteen),
            ("linux", ColorDepth::Sixteen),
            ("screen", ColorDepth::Sixteen),
            ("vt100", ColorDepth::None),
            ("xterm-m", ColorDepth::None),
        ] {
            assert_eq!(of(&[("TERM", term)]), depth, "{term}");
        }
    }
}
