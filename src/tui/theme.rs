//! Colours by role, from a file; how many of them the terminal has.

use std::path::Path;

use ratatui::style::{Color, Modifier, Style};
use serde::Deserialize;

use crate::system;

/// A colour for every role.
#[derive(Debug, Clone, PartialEq)]
pub struct Theme {
    /// What it is called.
    pub name: String,
    /// Whether it is made for dark backgrounds.
    pub dark: bool,
    /// Ordinary text.
    pub text: Color,
    /// Text that matters less.
    pub dim: Color,
    /// Titles of panes.
    pub title: Color,
    /// Keys, links, what can be acted on.
    pub accent: Color,
    /// Borders.
    pub border: Color,
    /// The border of the pane that has the keys.
    pub border_focused: Color,
    /// Background of the selected line.
    pub selection: Color,
    /// The ego.
    pub ego: Color,
    /// Moving obstacles.
    pub obstacle: Color,
    /// Standing obstacles.
    pub static_obstacle: Color,
    /// The picked obstacle.
    pub picked: Color,
    /// Collisions, errors, disagreement.
    pub danger: Color,
    /// Near misses, warnings.
    pub warning: Color,
    /// Safe, agreement.
    pub safe: Color,
    /// Solid lane borders.
    pub lane: Color,
    /// Dashed lane borders.
    pub lane_dashed: Color,
    /// Crosswalks.
    pub crosswalk: Color,
    /// Where obstacles have been.
    pub trail: Color,
    /// Where the ego has been.
    pub ego_trail: Color,
    /// Goal lanelets.
    pub goal: Color,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    dark: bool,
    roles: toml::Table,
}

const SHIPPED: &[(&str, &str)] = &[
    ("dark", include_str!("../../themes/dark.toml")),
    ("light", include_str!("../../themes/light.toml")),
    ("contrast", include_str!("../../themes/contrast.toml")),
];

/// How many colours a terminal shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// All of them.
    True,
    /// 256.
    Indexed,
    /// None: `NO_COLOR` is set.
    None,
}

impl Depth {
    /// What the environment says.
    #[must_use]
    pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Self {
        if env("NO_COLOR").is_some_and(|v| !v.is_empty()) {
            return Self::None;
        }
        match env("COLORTERM").as_deref() {
            Some("truecolor" | "24bit") => Self::True,
            _ => Self::Indexed,
        }
    }
}

impl Theme {
    /// Names of the themes that come with the program.
    pub fn shipped() -> impl Iterator<Item = &'static str> {
        SHIPPED.iter().map(|(name, _)| *name)
    }

    /// The theme `name`: the user's file of that name in `folder`, else a shipped one.
    ///
    /// # Errors
    /// There is none, or its file is wrong: with file and key.
    pub fn load(name: &str, folder: &Path) -> Result<Self, String> {
        let path = folder.join(format!("{name}.toml"));
        if !name.contains(['/', '\\']) && path.exists() {
            let text = system::read_text(&path, system::LARGEST_TEXT)
                .map_err(|e| format!("{}: {}", path.display(), system::words(&e)))?;
            return Self::parse(&text).map_err(|e| format!("{}: {e}", path.display()));
        }
        match SHIPPED.iter().find(|(shipped, _)| *shipped == name) {
            Some((_, text)) => Self::parse(text),
            None => {
                let names: Vec<&str> = Self::shipped().collect();
                Err(format!(
                    "no theme `{name}`; there are {} and files in {}",
                    names.join(", "),
                    folder.display()
                ))
            }
        }
    }

    /// The default theme.
    #[must_use]
    pub fn default_theme() -> Self {
        // The shipped files are read by a test.
        Self::parse(SHIPPED[0].1).unwrap_or_else(|_| Self::plain())
    }

    fn parse(text: &str) -> Result<Self, String> {
        let file: File = toml::from_str(text).map_err(|e| {
            let line = e.span().map_or(0, |s| {
                1 + text[..s.start.min(text.len())].matches('\n').count()
            });
            format!("line {line}: {}", e.message())
        })?;
        let mut theme = Self::plain();
        theme.name = file.name;
        theme.dark = file.dark;
        for (key, value) in &file.roles {
            let role = theme
                .role_mut(key)
                .ok_or_else(|| format!("roles.{key} is not a role"))?;
            *role = color(value).ok_or_else(|| format!("roles.{key} = {value} is not a colour"))?;
        }
        Ok(theme)
    }

    /// The same theme for a terminal with fewer colours.
    #[must_use]
    pub fn at_depth(mut self, depth: Depth) -> Self {
        for name in ROLES {
            if let Some(role) = self.role_mut(name) {
                *role = match (depth, *role) {
                    (Depth::None, _) => Color::Reset,
                    (Depth::Indexed, Color::Rgb(r, g, b)) => Color::Indexed(nearest(r, g, b)),
                    (_, color) => color,
                };
            }
        }
        self
    }

    /// Ordinary text.
    #[must_use]
    pub fn base(&self) -> Style {
        Style::new().fg(self.text)
    }

    /// The selected line: reversed where there is no colour for it, bold always.
    #[must_use]
    pub fn selected(&self) -> Style {
        let style = Style::new().add_modifier(Modifier::BOLD);
        if self.selection == Color::Reset {
            style.add_modifier(Modifier::REVERSED)
        } else {
            style.fg(self.text).bg(self.selection)
        }
    }

    /// The colour of a risk score, 0 to 5.
    #[must_use]
    pub fn risk(&self, score: f64) -> Color {
        if score < 1.5 {
            self.danger
        } else if score < 3.5 {
            self.warning
        } else {
            self.safe
        }
    }

    fn plain() -> Self {
        let c = Color::Reset;
        Self {
            name: "plain".into(),
            dark: true,
            text: c,
            dim: c,
            title: c,
            accent: c,
            border: c,
            border_focused: c,
            selection: c,
            ego: c,
            obstacle: c,
            static_obstacle: c,
            picked: c,
            danger: c,
            warning: c,
            safe: c,
            lane: c,
            lane_dashed: c,
            crosswalk: c,
            trail: c,
            ego_trail: c,
            goal: c,
        }
    }

    fn role_mut(&mut self, name: &str) -> Option<&mut Color> {
        Some(match name {
            "text" => &mut self.text,
            "dim" => &mut self.dim,
            "title" => &mut self.title,
            "accent" => &mut self.accent,
            "border" => &mut self.border,
            "border_focused" => &mut self.border_focused,
            "selection" => &mut self.selection,
            "ego" => &mut self.ego,
            "obstacle" => &mut self.obstacle,
            "static_obstacle" => &mut self.static_obstacle,
            "picked" => &mut self.picked,
            "danger" => &mut self.danger,
            "warning" => &mut self.warning,
            "safe" => &mut self.safe,
            "lane" => &mut self.lane,
            "lane_dashed" => &mut self.lane_dashed,
            "crosswalk" => &mut self.crosswalk,
            "trail" => &mut self.trail,
            "ego_trail" => &mut self.ego_trail,
            "goal" => &mut self.goal,
            _ => return None,
        })
    }
}

const ROLES: &[&str] = &[
    "text",
    "dim",
    "title",
    "accent",
    "border",
    "border_focused",
    "selection",
    "ego",
    "obstacle",
    "static_obstacle",
    "picked",
    "danger",
    "warning",
    "safe",
    "lane",
    "lane_dashed",
    "crosswalk",
    "trail",
    "ego_trail",
    "goal",
];

fn color(value: &toml::Value) -> Option<Color> {
    match value {
        toml::Value::Integer(index) => u8::try_from(*index).ok().map(Color::Indexed),
        toml::Value::String(text) => text.parse().ok(),
        _ => None,
    }
}

/// The nearest of the 240 colours that are the same in every terminal of 256.
fn nearest(r: u8, g: u8, b: u8) -> u8 {
    const STEPS: [u8; 6] = [0, 95, 135, 175, 215, 255];
    let step = |v: u8| (0..6).min_by_key(|&i| STEPS[i].abs_diff(v)).unwrap_or(0);
    let off = |x: u8, y: u8| i32::from(x.abs_diff(y)).pow(2);
    let (ri, gi, bi) = (step(r), step(g), step(b));
    let cube = off(STEPS[ri], r) + off(STEPS[gi], g) + off(STEPS[bi], b);
    let mean = (i32::from(r) + i32::from(g) + i32::from(b)) / 3;
    let gray = ((mean - 8 + 5) / 10).clamp(0, 23);
    let level = u8::try_from(8 + gray * 10).unwrap_or(u8::MAX);
    let gray_off = off(level, r) + off(level, g) + off(level, b);
    let index = if gray_off < cube {
        232 + gray as usize
    } else {
        16 + 36 * ri + 6 * gi + bi
    };
    u8::try_from(index).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn shipped_themes_give_every_role() {
        for (name, text) in SHIPPED {
            let mut theme = Theme::parse(text).unwrap();
            assert_eq!(theme.name, *name);
            for role in ROLES {
                assert_ne!(
                    *theme.role_mut(role).unwrap(),
                    Color::Reset,
                    "{name}: {role}"
                );
            }
        }
    }

    #[test]
    fn fewer_colours() {
        assert_eq!(nearest(255, 0, 0), 196);
        assert_eq!(nearest(128, 128, 128), 244);
        let none = Theme::default_theme().at_depth(Depth::None);
        assert_eq!(none.danger, Color::Reset);
        assert!(none.selected().add_modifier.contains(Modifier::REVERSED));
        assert_eq!(
            Depth::of_environment(|n| (n == "NO_COLOR").then(|| "1".into())),
            Depth::None
        );
    }

    #[test]
    fn mistakes_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        std::fs::write(
            &path,
            "name = \"mine\"\ndark = true\n[roles]\ntext = \"blurple\"\n",
        )
        .unwrap();
        assert!(
            Theme::load("mine", folder.path())
                .unwrap_err()
                .contains("roles.text")
        );
        assert!(
            Theme::load("none", folder.path())
                .unwrap_err()
                .contains("contrast")
        );
    }
}
