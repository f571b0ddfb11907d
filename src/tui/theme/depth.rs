//! Detects the terminal's colour depth from the environment.

/// Colour depth of a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
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

impl Depth {
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
            Depth::of_environment(|name| {
                let pair = pairs.iter().find(|(n, _)| *n == name);
                pair.map(|(_, value)| (*value).to_string())
            })
        };
        assert_eq!(
            of(&[("NO_COLOR", "1"), ("COLORTERM", "truecolor")]),
            Depth::None
        );
        assert_eq!(
            of(&[("NO_COLOR", ""), ("COLORTERM", "truecolor")]),
            Depth::True
        );
        for (term, depth) in [
            ("xterm-256color", Depth::Indexed),
            ("xterm-kitty", Depth::Indexed),
            ("xterm-direct", Depth::True),
            ("xterm", Depth::Sixteen),
            ("linux", Depth::Sixteen),
            ("screen", Depth::Sixteen),
            ("vt100", Depth::None),
            ("xterm-m", Depth::None),
        ] {
            assert_eq!(of(&[("TERM", term)]), depth, "{term}");
        }
    }
}
