//! The colours of pictures by role: for print on white, and as the themes of the terminal have them; how they mix.

use std::path::Path;

use nearmiss_base::system::unknown;
use nearmiss_settings::{AUTO, NamedTheme, ThemeColor, ThemeFile};

/// A colour for every role.
#[derive(Debug, Clone, PartialEq)]
pub struct Palette {
    /// Behind everything.
    pub background: Color,
    /// Text and axes.
    pub text: Color,
    /// Text that matters less, ticks, thresholds.
    pub dim: Color,
    /// Grid lines and frames.
    pub grid: Color,
    /// The window of a question in a plot.
    pub shade: Color,
    /// The surface of the road.
    pub road: Color,
    /// The surface of pavements and of lanes for bicycles.
    pub path: Color,
    /// Solid borders of lanes, kerbs, stop lines.
    pub lane: Color,
    /// Dashed borders of lanes.
    pub lane_dashed: Color,
    /// Stripes of crossings.
    pub crosswalk: Color,
    /// Goal regions.
    pub goal: Color,
    /// The ego.
    pub ego: Color,
    /// Moving obstacles.
    pub obstacle: Color,
    /// Standing obstacles.
    pub static_obstacle: Color,
    /// Contact.
    pub danger: Color,
    /// The time that a plot is read at.
    pub accent: Color,
    /// Obstacles that are pointed out, one after the other.
    pub emphasis: [Color; 5],
}

/// For print: the colours of Okabe and Ito, told apart by the colour-blind, on white.
const PAPER: Palette = Palette {
    background: Color::hex(0xffffff),
    text: Color::hex(0x1a1a1a),
    dim: Color::hex(0x666666),
    grid: Color::hex(0xdddddd),
    shade: Color::hex(0xe9f0f6),
    road: Color::hex(0xebedef),
    path: Color::hex(0xf5f3ee),
    lane: Color::hex(0x80868c),
    lane_dashed: Color::hex(0x9aa0a6),
    crosswalk: Color::hex(0xffffff),
    goal: Color::hex(0x009e73),
    ego: Color::hex(0x0072b2),
    obstacle: Color::hex(0x8d939a),
    static_obstacle: Color::hex(0xb9bdc2),
    danger: Color::hex(0xc00020),
    accent: Color::hex(0x333333),
    emphasis: [
        Color::hex(0xd55e00),
        Color::hex(0xcc79a7),
        Color::hex(0x009e73),
        Color::hex(0x8a6d00),
        Color::hex(0x56b4e9),
    ],
};

impl Palette {
    /// The one for print.
    #[must_use]
    pub fn paper() -> Self {
        PAPER
    }

    /// Names of those that come with the program.
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        let shipped = ThemeFile::shipped();
        let pairs = ThemeFile::pairs().filter(|name| *name != AUTO);
        std::iter::once("paper")
            .chain(shipped)
            .chain(pairs)
            .collect()
    }

    /// The one called `name`: `paper`, or a theme of the terminal: a file in `folder`, else a shipped one; of two, the
    /// dark one.
    ///
    /// # Errors
    /// There is none, or its file is wrong: every mistake, with file, line and key.
    pub fn named(name: &str, folder: &Path) -> Result<Self, String> {
        let all = ThemeFile::all(folder);
        let found = NamedTheme::find(&all, name, true).filter(|_| name != AUTO);
        match found.map(|named| &named.theme) {
            Some(theme) => match theme {
                Ok(theme) => Ok(Self::themed(theme)),
                Err(mistakes) => Err(mistakes.join("; ")),
            },
            None if name == "paper" => Ok(PAPER),
            None => Err(format!(
                "{}; your own themes go in {}",
                unknown("theme", name, Self::names()),
                folder.display()
            )),
        }
    }

    /// The colours of a theme of the terminal. Names of colours and indices have no fixed colour: such roles keep the
    /// colours of the paper, or of a dark one.
    #[must_use]
    pub fn themed(theme: &ThemeFile) -> Self {
        let base = if theme.dark {
            Self {
                background: Color::hex(0x15181d),
                text: Color::hex(0xd5d8de),
                dim: Color::hex(0x7f8794),
                ..PAPER
            }
        } else {
            PAPER
        };
        let or = |role: ThemeColor, otherwise: Color| match role {
            ThemeColor::Rgb(red, green, blue) => Color::rgb(red, green, blue),
            _ => otherwise,
        };
        let background = or(theme.background, base.background);
        let text = or(theme.text, base.text);
        let ego = or(theme.ego, base.ego);
        Self {
            background,
            text,
            dim: or(theme.dim, base.dim),
            grid: background.towards(text, 0.16),
            shade: or(theme.shade, background.towards(text, 0.07)),
            road: or(theme.map_road, background.towards(text, 0.07)),
            path: or(theme.map_path, background.towards(text, 0.04)),
            lane: or(theme.lane, base.lane),
            lane_dashed: or(theme.lane_dashed, base.lane_dashed),
            crosswalk: or(theme.crosswalk, base.crosswalk).towards(background, 0.4),
            goal: or(theme.goal, base.goal),
            ego,
            obstacle: or(theme.obstacle, base.obstacle).towards(background, 0.25),
            static_obstacle: or(theme.static_obstacle, base.static_obstacle)
                .towards(background, 0.3),
            danger: or(theme.danger, base.danger),
            accent: or(theme.accent, base.accent),
            emphasis: [
                or(theme.picked, PAPER.emphasis[0]),
                or(theme.agree, PAPER.emphasis[1]),
                or(theme.safe, PAPER.emphasis[2]),
                or(theme.accent, PAPER.emphasis[3]),
                or(theme.attacker, PAPER.emphasis[4]),
            ],
        }
    }

    /// The colour of the obstacle that is pointed out at this place.
    #[must_use]
    pub fn emphasised(&self, place: usize) -> Color {
        self.emphasis[place % self.emphasis.len()]
    }
}

/// A colour with its opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Color {
    /// Red, 0 to 255.
    pub red: u8,
    /// Green, 0 to 255.
    pub green: u8,
    /// Blue, 0 to 255.
    pub blue: u8,
    /// 0 is not seen, 1 hides what is below.
    pub opacity: f64,
}

impl Color {
    /// An opaque colour, `0xrrggbb`.
    #[must_use]
    pub const fn hex(rgb: u32) -> Self {
        let [_, red, green, blue] = rgb.to_be_bytes();
        Self::rgb(red, green, blue)
    }

    /// An opaque colour.
    #[must_use]
    pub const fn rgb(red: u8, green: u8, blue: u8) -> Self {
        Self {
            red,
            green,
            blue,
            opacity: 1.0,
        }
    }

    /// The same colour less opaque.
    #[must_use]
    pub const fn at(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// A part of the way from this colour to another one, 0 to 1.
    #[must_use]
    pub fn towards(self, other: Self, part: f64) -> Self {
        let between = |a: u8, b: u8| {
            let value = f64::from(a) + (f64::from(b) - f64::from(a)) * part;
            value.round().clamp(0.0, 255.0) as u8
        };
        Self {
            red: between(self.red, other.red),
            green: between(self.green, other.green),
            blue: between(self.blue, other.blue),
            opacity: self.opacity,
        }
    }
}

impl std::fmt::Display for Color {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.red, self.green, self.blue)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn shipped_ones_are_there_and_others_are_not() {
        let folder = tempfile::tempdir().unwrap();
        for name in Palette::names() {
            let palette = Palette::named(name, folder.path()).unwrap();
            assert_ne!(palette.background, palette.text, "{name}");
            assert_ne!(palette.ego, palette.emphasis[0], "{name}");
        }
        let error = Palette::named("sepia", folder.path()).unwrap_err();
        assert!(error.contains("paper, dark, light, contrast"), "{error}");
        std::fs::write(folder.path().join("mine.toml"), "dark = maybe").unwrap();
        let error = Palette::named("mine", folder.path()).unwrap_err();
        assert!(error.contains("mine.toml"), "{error}");
    }
}
