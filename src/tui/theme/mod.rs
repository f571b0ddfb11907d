//! Themes in the colours a terminal supports.

mod color;

use std::ops::{Deref, DerefMut};
use std::path::Path;

use nearmiss_base::system::{pad_end, unknown};
use nearmiss_scene::description::visible;
use nearmiss_settings as settings;
use nearmiss_settings::{NamedTheme, ThemeColor, ThemeFile};
use ratatui::buffer::Buffer;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use super::keymap::{all_visible, first_mistake};

pub use color::{ColorDepth, components};
pub use nearmiss_settings::{AUTO, ROLES};

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
            Some(theme) => theme
                .clone()
                .map(Self)
                .map_err(|mistakes| first_mistake(&mistakes)),
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

    /// A colour behind a window: half way to the background, where colours can be mixed.
    #[must_use]
    pub fn dimmed(&self, color: Color) -> Color {
        match (color, self.background) {
            (Color::Rgb(r, g, b), Color::Rgb(to_r, to_g, to_b)) => {
                Color::Rgb(r.midpoint(to_r), g.midpoint(to_g), b.midpoint(to_b))
            }
            _ => color,
        }
    }

    /// What dims text behind a window where colours cannot be mixed.
    #[must_use]
    pub fn dimming(&self) -> Modifier {
        match self.background {
            Color::Rgb(..) => Modifier::empty(),
            _ => Modifier::DIM,
        }
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
        } else if score < 2.5 {
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

/// A list of all themes, or everything about the one called `name`, in the colours of the terminal.
///
/// Without a terminal to show it, `depth` is nothing and the text is plain.
///
/// # Errors
/// The theme does not exist, or its file is invalid: with file, line and key.
pub fn preview(
    name: Option<&str>,
    folder: &Path,
    depth: Option<ColorDepth>,
) -> Result<String, String> {
    let styled = depth.is_some();
    let shown = |line: &Line<'_>| {
        if styled {
            color::line(line)
        } else {
            line.to_string()
        }
    };
    let depth = depth.unwrap_or(ColorDepth::None);
    let lines = match name {
        None => list(folder, depth),
        Some(name) => {
            let theme = Theme::load(name, folder, true)?;
            full_preview(&theme, depth)
        }
    };
    let lines = lines
        .iter()
        .map(|line| shown(line).trim_end().to_string() + "\n");
    Ok(lines.collect())
}

fn list(folder: &Path, depth: ColorDepth) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    for Named { name, file, theme } in Theme::all(folder) {
        let from = file.map_or("shipped".into(), |file| visible(&file).into_owned());
        match theme {
            Ok(theme) => {
                let ground = if theme.dark { "dark" } else { "light" };
                let about = format!("  for {ground} backgrounds, {from}");
                let theme = Theme(theme).at_depth(depth);
                let bold = theme.base().add_modifier(Modifier::BOLD);
                lines.push(Line::from(vec![
                    Span::styled(visible(&name).into_owned(), bold),
                    Span::styled(about, Style::new().fg(theme.dim)),
                ]));
                lines.extend(sample(&theme));
            }
            Err(mistakes) => {
                lines.push(Line::from(format!("{}  cannot be used", visible(&name))));
                lines.push(Line::from(format!("  {}", first_mistake(&mistakes))));
            }
        }
        lines.push(Line::default());
    }
    let pairs: Vec<&str> = ThemeFile::pairs().collect();
    lines.push(Line::from(format!(
        "Set one in config.toml: `theme = \"NAME\"`. {} follow the terminal's background.",
        pairs.join(", ")
    )));
    lines
}

/// A few words and signs as they stand in the workbench.
fn sample(theme: &Theme) -> Vec<Line<'static>> {
    let span = |text: &'static str, color: Color| Span::styled(text, Style::new().fg(color));
    let selected = Line::from(vec![Span::styled(" ▸ selected line 0X ", theme.selected())]);
    let mut upper = vec![
        Span::raw("  "),
        span("text ", theme.text),
        span("dim ", theme.dim),
    ];
    upper.extend([span("title ", theme.title), span("key ", theme.accent)]);
    upper.extend(selected.spans);
    let lower = vec![
        Span::raw("  "),
        span("collision ", theme.danger),
        span("near miss ", theme.danger_medium),
        span("= agrees ", theme.agree),
        span("≠ differs ", theme.disagree),
        span("▶ ego ", theme.ego),
        span("▭ 302 ", theme.obstacle),
        span("▬ parked ", theme.static_obstacle),
        span("▭ 301 picked ", theme.picked),
    ];
    let lanes = vec![
        Span::raw("  "),
        span("──── ", theme.lane),
        span("- - - ", theme.lane_dashed),
        span("··· ", theme.trail),
        span("··· ", theme.ego_trail),
        span("╌╌ ", theme.predicted),
        span("▒▒ ", theme.occupancy),
        span("├─┤ ", theme.tape),
        span("━━ ", theme.attacker),
        span("△ ", theme.sign),
        span("● ", theme.light_red),
        span("● ", theme.light_amber),
        span("● ", theme.light_green),
    ];
    vec![Line::from(upper), Line::from(lower), Line::from(lanes)]
}

/// Every role of a theme: its name in its colour, the colour of the file and the one that the terminal shows.
fn full_preview(theme: &Theme, depth: ColorDepth) -> Vec<Line<'static>> {
    let shown = theme.clone().at_depth(depth);
    let ground = if theme.dark { "dark" } else { "light" };
    let mut lines = vec![
        Line::from(format!(
            "{}, for {ground} backgrounds",
            visible(&theme.name)
        )),
        Line::default(),
    ];
    lines.extend(sample(&shown));
    lines.push(Line::default());
    let widest = ROLES.iter().map(|role| role.width()).max().unwrap_or(0);
    for role in ROLES {
        let (Some(said), Some(color)) = (theme.role(role), shown.role(role)) else {
            continue;
        };
        let style = Style::new().fg(color);
        let reversed = style.add_modifier(Modifier::REVERSED);
        let value = match (color == said, said) {
            (true, Color::Reset) => here(said),
            (true, _) => said.to_string(),
            (false, _) => format!("{said}, shown as {}", here(color)),
        };
        lines.push(Line::from(vec![
            Span::styled("    ", reversed),
            Span::styled(format!(" {}  ", pad_end(role, widest)), style),
            Span::raw(value),
        ]));
    }
    lines
}

/// A colour as this terminal has it.
fn here(color: Color) -> String {
    match (color, color::components(color)) {
        (Color::Reset, _) => "the terminal's own".into(),
        (Color::Indexed(index), Some([r, g, b])) => format!("{index} (#{r:02X}{g:02X}{b:02X})"),
        (color, _) => color.to_string(),
    }
}

#[cfg(test)]
mod sight;

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

    #[test]
    fn previews_have_the_colours_of_the_terminal_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let broken = folder.path().join("odd\u{1b}[2J.toml");
        std::fs::write(broken, "dark = 3\n").unwrap();
        for (depth, sign, others) in [
            (ColorDepth::True, "\x1b[38;2;", vec!["\x1b[38;5"]),
            (ColorDepth::Indexed, "\x1b[38;5;", vec!["\x1b[38;2"]),
            (
                ColorDepth::Sixteen,
                "\x1b[91m",
                vec!["\x1b[38;2", "\x1b[38;5"],
            ),
            (
                ColorDepth::None,
                "selected line",
                vec!["\x1b[38;2", "\x1b[38;5", "\x1b[9", "\x1b[3"],
            ),
        ] {
            let all = preview(None, folder.path(), Some(depth)).unwrap();
            let one = preview(Some("colorblind"), folder.path(), Some(depth)).unwrap();
            for text in [&all, &one] {
                assert!(text.contains(sign), "{depth:?}: {text:?}");
                assert!(
                    others.iter().all(|o| !text.contains(o)),
                    "{depth:?}: {text:?}"
                );
                assert!(!text.contains("\x1b[2J"), "{text:?}");
            }
            for name in ThemeFile::shipped().chain(ThemeFile::pairs()) {
                assert!(all.contains(name));
            }
            assert!(all.contains("dark must be true or false"), "{all}");
            assert!(ROLES.iter().all(|role| one.contains(role)));
        }
        let plain = preview(None, folder.path(), None).unwrap();
        assert!(plain.contains("selected line") && !plain.contains('\x1b'));
        assert!(preview(Some("none"), folder.path(), Some(ColorDepth::True)).is_err());
    }
}
