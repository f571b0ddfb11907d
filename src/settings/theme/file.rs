//! Theme files: the shipped ones and the user's.

use std::path::Path;

use ratatui::style::Color;
use toml::de::DeValue;

use super::{ROLES, Theme, color};
use crate::config::TextFile;
use crate::text::visible;
use crate::tui::user_file::{UserFile, first, shown};

const SHIPPED: &[(&str, &str)] = &[
    ("dark", include_str!("../../../themes/dark.toml")),
    ("light", include_str!("../../../themes/light.toml")),
    ("contrast", include_str!("../../../themes/contrast.toml")),
    (
        "colorblind",
        include_str!("../../../themes/colorblind.toml"),
    ),
];

/// The name that stands for dark or light, as the terminal's background is.
pub const AUTO: &str = "auto";

/// A theme that can be chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// By what name.
    pub name: String,
    /// The user's file; nothing for a shipped theme.
    pub file: Option<String>,
    /// The theme in all colours, or every mistake in its file.
    pub theme: Result<Theme, Vec<String>>,
}

impl Theme {
    /// Names of the themes that come with the program.
    pub fn shipped() -> impl Iterator<Item = &'static str> {
        SHIPPED.iter().map(|(name, _)| *name)
    }

    /// The theme `name`: the user's file of that name in `folder`, else a shipped one; `auto` is `dark` or `light`.
    ///
    /// # Errors
    /// There is none, or its file is wrong: with file, line and key.
    pub fn load(name: &str, folder: &Path, dark: bool) -> Result<Self, String> {
        let name = match name {
            AUTO if dark => "dark",
            AUTO => "light",
            name => name,
        };
        let all = Self::all(folder);
        match all.into_iter().find(|named| named.name == name) {
            Some(named) => named.theme.map_err(|mistakes| first(&mistakes)),
            None => Err(Self::unknown(name, folder)),
        }
    }

    /// There is no such theme.
    fn unknown(name: &str, folder: &Path) -> String {
        let names: Vec<&str> = Self::shipped().collect();
        format!(
            "no theme `{name}`; there are {AUTO}, {} and files in {}",
            names.join(", "),
            folder.display()
        )
    }

    /// Every theme that can be chosen: the shipped ones, in whose place a file of the user's may be, and the user's.
    #[must_use]
    pub fn all(folder: &Path) -> Vec<Named> {
        let mut all: Vec<Named> = SHIPPED
            .iter()
            .map(|(name, text)| Named {
                name: (*name).into(),
                file: None,
                theme: Self::parse(name, &format!("the shipped {name}.toml"), text),
            })
            .collect();
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut own: Vec<Named> = files.filter_map(|entry| own(&entry.path())).collect();
        own.sort_by(|a, b| a.name.cmp(&b.name));
        for named in own {
            match all.iter_mut().find(|other| other.name == named.name) {
                Some(shipped) => *shipped = named,
                None => all.push(named),
            }
        }
        all
    }

    /// The default theme for a dark or a light background.
    #[must_use]
    pub fn default_for(dark: bool) -> Self {
        let (name, text) = SHIPPED[usize::from(!dark)];
        // The shipped files are read by a test.
        Self::parse(name, name, text).unwrap_or_else(|_| Self::plain())
    }

    /// The default theme.
    #[cfg(test)]
    pub fn default_theme() -> Self {
        Self::default_for(true)
    }

    /// Reads a theme; roles that the file leaves out are as in the default theme for that background.
    ///
    /// # Errors
    /// Every mistake, with file, line and key.
    pub fn parse(name: &str, file: &str, text: &str) -> Result<Self, Vec<String>> {
        let mut said = UserFile::new(file, text);
        let Some(table) = said.table() else {
            said.checked()?;
            return Err(Vec::new());
        };
        let mut dark = None;
        let mut roles = Vec::new();
        let mut sixteen = Vec::new();
        for (key, value) in &table {
            match key.get_ref().as_ref() {
                "name" if value.get_ref().is_str() => {}
                "name" => said.mistake(&key.span(), "name must be a text"),
                "dark" => match value.get_ref().as_bool() {
                    Some(is) => dark = Some(is),
                    None => said.mistake(&key.span(), "dark must be true or false"),
                },
                part @ ("roles" | "sixteen") => {
                    let Some(below) = said.below(part, value) else {
                        continue;
                    };
                    for (role, value) in below {
                        let name = role.get_ref().as_ref();
                        let Some(known) = ROLES.iter().find(|known| **known == name) else {
                            said.mistake(
                                &role.span(),
                                &format!("{part}.{name} is not a role{}", near(name)),
                            );
                            continue;
                        };
                        match color_of(value.get_ref()) {
                            Some(color) if part == "roles" => roles.push((*known, color)),
                            Some(color) if color == Color::Reset || color::number(color).is_some() => {
                                sixteen.push((*known, color));
                            }
                            _ => said.mistake(
                                &value.span(),
                                &format!(
                                    "{part}.{name} = {} is not {}",
                                    shown(value.get_ref()),
                                    if part == "roles" {
                                        "a colour: \"#rrggbb\", a name such as \"red\", 0 to 255, or \"reset\""
                                    } else {
                                        "one of the sixteen colours, such as \"red\" or \"lightred\""
                                    }
                                ),
                            ),
                        }
                    }
                }
                other => said.mistake(
                    &key.span(),
                    &format!("{other} is not known; there are name, dark, [roles] and [sixteen]"),
                ),
            }
        }
        if dark.is_none() {
            said.mistake(
                &(0..0),
                "dark is missing: true for dark backgrounds, else false",
            );
        }
        said.checked()?;
        let dark = dark.unwrap_or(true);
        let complete = ROLES
            .iter()
            .all(|role| roles.iter().any(|(r, _)| r == role));
        let mut theme = if complete {
            Self::plain()
        } else {
            Self::default_for(dark)
        };
        theme.name = name.into();
        theme.dark = dark;
        // What stands for the default's colours does not stand for the user's.
        theme
            .sixteen
            .retain(|(role, _)| roles.iter().all(|(own, _)| own != role));
        theme.sixteen.extend(sixteen);
        for (role, color) in roles {
            if let Some(place) = theme.role_mut(role) {
                *place = color;
            }
        }
        Ok(theme)
    }
}

/// A file of the user's, if it is a theme by its name.
fn own(path: &Path) -> Option<Named> {
    let name = path
        .file_name()?
        .to_str()?
        .strip_suffix(".toml")?
        .to_string();
    let theme = TextFile::read(path)
        .map_err(|error| vec![visible(&error).into_owned()])
        .and_then(|said| Theme::parse(&name, &said.file, &said.text));
    Some(Named {
        name,
        file: Some(path.display().to_string()),
        theme,
    })
}

/// The role that was probably meant.
fn near(name: &str) -> String {
    let best = ROLES
        .iter()
        .max_by(|a, b| strsim::jaro(name, a).total_cmp(&strsim::jaro(name, b)))
        .filter(|role| strsim::jaro(name, role) > 0.75);
    best.map_or(String::new(), |role| format!("; did you mean {role}?"))
}

fn color_of(value: &DeValue<'_>) -> Option<Color> {
    match value {
        DeValue::Integer(index) => index.as_str().parse().ok().map(Color::Indexed),
        DeValue::String(text) => color::named(text),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::tui::theme::Depth;

    #[test]
    fn shipped_themes_give_every_role_at_every_depth() {
        for (name, text) in SHIPPED {
            for role in ROLES {
                let line = format!("\n{role} = ");
                assert!(text.contains(&line), "{name}: {role}");
            }
            let theme = Theme::parse(name, name, text).unwrap();
            for depth in [Depth::True, Depth::Indexed, Depth::Sixteen] {
                let theme = theme.clone().at_depth(depth);
                for role in ROLES {
                    let color = theme.role(role).unwrap();
                    assert_ne!(color, Color::Reset, "{name}: {role}");
                    let few = color::number(color).is_some();
                    assert!(few || depth != Depth::Sixteen, "{name}: {role} {color}");
                }
            }
        }
    }

    #[test]
    fn mistakes_are_named_by_line_and_key() {
        let text = "name = \"mine\"\ndark = true\nbright = 1\n[roles]\ntext = \"blurple\"\ndangr = \"red\"\ndim = 300\n\n[sixteen]\ntext = \"#ffffff\"\n";
        let mistakes = Theme::parse("mine", "mine.toml", text).unwrap_err();
        let found = [
            "mine.toml:3: bright is not known",
            "mine.toml:5: roles.text = \"blurple\" is not a colour",
            "mine.toml:6: roles.dangr is not a role; did you mean danger?",
            "mine.toml:7: roles.dim = 300",
            "mine.toml:10: sixteen.text",
        ];
        assert_eq!(mistakes.len(), found.len(), "{mistakes:#?}");
        for (mistake, start) in mistakes.iter().zip(found) {
            assert!(mistake.starts_with(start), "{mistake}");
        }
        let broken = Theme::parse("mine", "mine.toml", "name = \"mine\"\ndark = \n").unwrap_err();
        assert!(broken[0].starts_with("mine.toml:2: "), "{broken:?}");
    }

    #[test]
    fn roles_left_out_are_the_default_ones() {
        let theme = Theme::parse("mine", "f", "dark = false\n[roles]\ntext = 160\n").unwrap();
        let light = Theme::default_for(false);
        assert_eq!(theme.text, Color::Indexed(160));
        assert_eq!((theme.danger, &theme.name[..]), (light.danger, "mine"));
        // Not black, which stands for the default's text.
        let few = theme.at_depth(Depth::Sixteen);
        assert_ne!(few.text, light.clone().at_depth(Depth::Sixteen).text);
        assert_eq!(few.danger, light.at_depth(Depth::Sixteen).danger);
    }

    #[test]
    fn files_come_before_shipped_themes_of_their_name() {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("dark.toml", "dark = true\n[roles]\ntext = \"red\"\n");
        write("mine.toml", "dark = true\n[roles]\ntext = 3.5\n");
        write("notes.txt", "no theme");
        let load = |name: &str| Theme::load(name, folder.path(), true);
        assert_eq!(load("dark").unwrap().text, Color::Red);
        assert_eq!(load("auto").unwrap().text, Color::Red);
        assert!(
            load("mine")
                .unwrap_err()
                .contains("mine.toml:3: roles.text")
        );
        assert!(load("none").unwrap_err().contains("contrast"));
        assert!(load("../dark").unwrap_err().contains("no theme"));
        let names: Vec<String> = Theme::all(folder.path())
            .into_iter()
            .map(|n| n.name)
            .collect();
        assert_eq!(names, ["dark", "light", "contrast", "colorblind", "mine"]);
    }
}
