//! Themes in the colours a terminal supports.

mod ansi;
mod color;
mod depth;
mod preview;
#[cfg(test)]
mod sight;

use std::ops::{Deref, DerefMut};
use std::path::Path;

use ratatui::buffer::Buffer;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Line;

use super::user_file::{all_visible, first};
use nearmiss_base::system::unknown;
use nearmiss_settings::{self as settings, NamedTheme, ThemeColor, ThemeFile};

pub use color::components;
pub use depth::ColorDepth;
pub use nearmiss_settings::{AUTO, ROLES};
pub use preview::preview;

/// Roles that lie behind others.
const SURFACES: &[&str] = &[
    "background",
    "shade",
    "map_ground",
    "map_road",
    "map_junction",
    "map_path",
];

/// A theme in the colours of a terminal.
#[derive(Debug, Clone, PartialEq)]
pub struct Theme(pub settings::Theme<Color>);

/// A theme that can be chosen, in the colours of a terminal.
pub type Named = NamedTheme<Color>;

impl Deref for Theme {
    type Target = settings::Theme<Color>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Theme {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl Theme {
    /// The theme `name`: the user's file of that name in `folder`, else a shipped one; `auto`, `contrast` and
    /// `colorblind` are one of two, for dark and for light backgrounds.
    ///
    /// # Errors
    /// It does not exist, or its file is invalid: with file, line and key.
    pub fn load(name: &str, folder: &Path, dark: bool) -> Result<Self, String> {
        let all = Self::all(folder);
        match Named::find(&all, name, dark).map(|named| &named.theme) {
            Some(theme) => theme.clone().map(Self).map_err(|mistakes| first(&mistakes)),
            None => Err(Self::unknown(name, folder)),
        }
    }

    /// The theme does not exist.
    fn unknown(name: &str, folder: &Path) -> String {
        let names: Vec<&str> = ThemeFile::pairs().chain(ThemeFile::shipped()).collect();
        format!(
            "{}; `nearmiss config themes` lists all, your own go in {}",
            unknown("theme", name, names.iter().copied()),
            folder.display()
        )
    }

    /// Every theme that can be chosen: the shipped ones, in whose place a file of the user's may be, and the user's.
    #[must_use]
    pub fn all(folder: &Path) -> Vec<Named> {
        let terminal = |named: NamedTheme<ThemeColor>| Named {
            name: named.name,
            file: named.file,
            theme: match named.theme {
                Ok(theme) => Ok(theme.map(color::terminal_color)),
                Err(mistakes) => Err(all_visible(mistakes)),
            },
        };
        ThemeFile::all(folder).into_iter().map(terminal).collect()
    }

    /// The default theme for a dark or a light background.
    #[must_use]
    pub fn default_for(dark: bool) -> Self {
        Self(ThemeFile::default_for(dark).map(color::terminal_color))
    }

    /// The default theme.
    #[cfg(test)]
    pub fn default_theme() -> Self {
        Self::default_for(true)
    }

    /// The same theme for a terminal with fewer colours.
    #[must_use]
    pub fn at_depth(mut self, depth: ColorDepth) -> Self {
        let sixteen = std::mem::take(&mut self.sixteen);
        let dark = self.dark;
        for name in ROLES {
            let own = sixteen.iter().find(|(role, _)| role == name);
            if let Some(role) = self.role_mut(name) {
                *role = match (depth, own) {
                    (ColorDepth::Sixteen, Some((_, color))) => *color,
                    _ if SURFACES.contains(name) => color::surface_at_depth(*role, depth),
                    _ => color::at_depth(*role, depth, dark),
                };
            }
        }
        self.sixteen = sixteen;
        self
    }

    /// Ordinary text.
    #[must_use]
    pub fn base(&self) -> Style {
        Style::new().fg(self.text)
    }

    /// The selected line: a bar that is reversed, so that it is seen on any background and without colours.
    ///
    /// The bar is the role `selection`, the words on it are `text`. Spans with colours of their own would become
    /// patches: [`Theme::select`] takes them off.
    #[must_use]
    pub fn selected(&self) -> Style {
        Style::new()
            .add_modifier(Modifier::BOLD | Modifier::REVERSED)
            .fg(self.selection)
            .bg(self.text)
    }

    /// A line as the selected one, see [`Theme::selected`].
    #[must_use]
    pub fn select<'a>(&self, mut line: Line<'a>) -> Line<'a> {
        for span in &mut line.spans {
            span.style.fg = None;
            span.style.bg = None;
        }
        line.style(self.selected())
    }

    /// The colour of a risk score, 0 to 5: one hue, the stronger the more dangerous.
    #[must_use]
    pub fn risk(&self, score: f64) -> Color {
        if score < 1.5 {
            self.danger
        } else if score < 3.5 {
            self.danger_medium
        } else {
            self.danger_low
        }
    }

    /// Paints what has no colours of its own in those of the theme. Without a background of the theme's, the terminal's
    /// colours show.
    pub fn paint(&self, buffer: &mut Buffer) {
        if self.background == Color::Reset {
            return;
        }
        for cell in &mut buffer.content {
            if cell.bg == Color::Reset {
                cell.bg = self.background;
            }
            if cell.fg == Color::Reset {
                cell.fg = self.text;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn shipped_themes_give_every_role_at_every_depth() {
        let nowhere = Path::new("/nonexistent");
        for name in ThemeFile::shipped() {
            let theme = Theme::load(name, nowhere, true).unwrap();
            for depth in [ColorDepth::True, ColorDepth::Indexed, ColorDepth::Sixteen] {
                let theme = theme.clone().at_depth(depth);
                for role in ROLES {
                    let color = theme.role(role).unwrap();
                    assert_ne!(color, Color::Reset, "{name}: {role}");
                    let few = color::number(color).is_some();
                    assert!(
                        few || depth != ColorDepth::Sixteen,
                        "{name}: {role} {color}"
                    );
                }
            }
        }
    }

    #[test]
    fn themes_are_found_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("dark.toml", "dark = true\n[roles]\ntext = \"red\"\n");
        write("mine.toml", "dark = false\n[roles]\ntext = 160\n");
        write("odd.toml", "dark = true\n[roles]\n\"a\\u001b[2J\" = 3\n");
        let load = |name: &str| Theme::load(name, folder.path(), true);
        assert_eq!(load("dark").unwrap().text, Color::Red);
        assert_eq!(load("auto").unwrap().text, Color::Red);
        assert_eq!(load("contrast").unwrap().name, "contrast-dark");
        assert!(
            load("none")
                .unwrap_err()
                .contains("auto, contrast, colorblind")
        );
        assert!(load("../dark").unwrap_err().contains("unknown theme"));
        let odd = load("odd").unwrap_err();
        assert!(
            odd.contains("odd.toml:3: unknown role `roles.a") && !odd.contains('\x1b'),
            "{odd:?}"
        );
        // Not black, which stands for the default's text.
        let (mine, light) = (load("mine").unwrap(), Theme::default_for(false));
        let (mine, light) = (
            mine.at_depth(ColorDepth::Sixteen),
            light.at_depth(ColorDepth::Sixteen),
        );
        assert_ne!(mine.text, light.text);
        assert_eq!(mine.danger, light.danger);
    }

    #[test]
    fn the_background_is_painted_unless_it_is_the_terminals() {
        let folder = tempfile::tempdir().unwrap();
        let none = "dark = true\n[roles]\nbackground = \"none\"\n";
        std::fs::write(folder.path().join("clear.toml"), none).unwrap();
        let painted = |name: &str, depth| {
            let theme = Theme::load(name, folder.path(), true)
                .unwrap()
                .at_depth(depth);
            let mut buffer = Buffer::with_lines(["ab"]);
            buffer[(1, 0)].set_fg(Color::Red).set_bg(Color::Blue);
            theme.paint(&mut buffer);
            (
                theme,
                [0, 1].map(|x| (buffer[(x, 0)].fg, buffer[(x, 0)].bg)),
            )
        };
        let own = (Color::Red, Color::Blue);
        for depth in [ColorDepth::True, ColorDepth::Indexed, ColorDepth::Sixteen] {
            for name in ThemeFile::shipped() {
                let (theme, cells) = painted(name, depth);
                assert_eq!(cells, [(theme.text, theme.background), own], "{name}");
                assert_ne!(theme.background, Color::Reset);
            }
            let (_, cells) = painted("clear", depth);
            assert_eq!(cells, [(Color::Reset, Color::Reset), own]);
        }
        let (_, cells) = painted("dark", ColorDepth::None);
        assert_eq!(cells[0], (Color::Reset, Color::Reset));
    }
}
