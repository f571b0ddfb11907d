//! The block characters of a map: how finely they divide a cell, and which a terminal draws.

use ratatui::symbols::pixel::{OCTANTS, QUADRANTS, SEXTANTS};

/// How finely a character divides its cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blocks {
    /// 2 × 2, which every font has.
    Quadrants,
    /// 2 × 3, Unicode 13.
    Sextants,
    /// 2 × 4, Unicode 16.
    Octants,
}

impl Blocks {
    /// All with their names in the configuration.
    pub const NAMED: [(&str, Self); 3] = [
        ("quadrants", Self::Quadrants),
        ("sextants", Self::Sextants),
        ("octants", Self::Octants),
    ];

    /// What the terminal draws itself, whatever the font has: by `TERM` and `TERM_PROGRAM`. Within tmux and screen the
    /// outer terminal is not known, so quadrants are used.
    #[must_use]
    pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Self {
        let value = |name: &str| env(name).unwrap_or_default().to_lowercase();
        let (term, program) = (value("TERM"), value("TERM_PROGRAM"));
        let is = |names: &[&str]| {
            let said = |name: &&str| term.contains(*name) || program.contains(*name);
            names.iter().any(said)
        };
        if is(&["tmux", "screen"]) {
            return Self::Quadrants;
        }
        // Ghostty draws octants since its first release.
        if is(&["ghostty"]) {
            return Self::Octants;
        }
        let vte = value("VTE_VERSION").parse::<u32>().unwrap_or(0);
        let known = is(&["kitty", "foot", "wezterm", "alacritty", "contour", "iterm"]);
        // VTE (GNOME Terminal and others) draws sextants since 0.62, Windows Terminal since 1.22, which WT_SESSION does
        // not tell.
        if known || vte >= 6200 {
            Self::Sextants
        } else {
            Self::Quadrants
        }
    }

    /// Columns and rows of a cell.
    #[must_use]
    pub fn per_cell(self) -> (usize, usize) {
        match self {
            Self::Quadrants => (2, 2),
            Self::Sextants => (2, 3),
            Self::Octants => (2, 4),
        }
    }

    /// Which parts of its cell a character fills: a bit each, row by row; `None` for one that is no block.
    #[must_use]
    pub fn of_symbol(symbol: char) -> Option<(Self, usize)> {
        let mut named = Self::NAMED.into_iter();
        named.find_map(|(_, blocks)| {
            let parts = blocks.symbols().iter().position(|c| *c == symbol)?;
            (parts > 0).then_some((blocks, parts))
        })
    }

    fn symbols(self) -> &'static [char] {
        match self {
            Self::Quadrants => &QUADRANTS,
            Self::Sextants => &SEXTANTS,
            Self::Octants => &OCTANTS,
        }
    }

    /// The character in which these parts are filled: a bit each, row by row.
    #[must_use]
    pub fn symbol(self, parts: usize) -> char {
        self.symbols().get(parts).copied().unwrap_or('█')
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_by_their_parts() {
        assert_eq!(Blocks::Quadrants.symbol(0b0101), '▌');
        assert_eq!(Blocks::Sextants.symbol(0b01_0101), '▌');
        assert_eq!(Blocks::Octants.symbol(0b0000_1111), '▀');
        assert_eq!(Blocks::of_symbol('▚'), Some((Blocks::Quadrants, 0b1001)));
        assert_eq!(Blocks::of_symbol('a').or(Blocks::of_symbol(' ')), None);
        for (_, blocks) in Blocks::NAMED {
            let (across, down) = blocks.per_cell();
            let full = (1 << (across * down)) - 1;
            assert_eq!((blocks.symbol(0), blocks.symbol(full)), (' ', '█'));
            // Every character is read as what it fills, by the coarsest division that has it.
            for parts in 1..=full {
                let symbol = blocks.symbol(parts);
                let read = Blocks::of_symbol(symbol).map(|(read, parts)| read.symbol(parts));
                assert_eq!(read, Some(symbol));
            }
        }
    }

    #[test]
    fn the_terminal_says_what_it_draws() {
        let of = |pairs: &[(&str, &str)]| {
            Blocks::of_environment(|name| {
                let pair = pairs.iter().find(|(n, _)| *n == name);
                pair.map(|(_, value)| (*value).to_string())
            })
        };
        assert_eq!(of(&[("TERM", "xterm-256color")]), Blocks::Quadrants);
        assert_eq!(of(&[("TERM", "xterm-kitty")]), Blocks::Sextants);
        assert_eq!(of(&[("TERM_PROGRAM", "ghostty")]), Blocks::Octants);
        let vte = [("TERM", "xterm-256color"), ("VTE_VERSION", "7600")];
        assert_eq!(of(&vte), Blocks::Sextants);
        let tmux = [("TERM", "tmux-256color"), ("VTE_VERSION", "7600")];
        assert_eq!(of(&tmux), Blocks::Quadrants);
    }
}
