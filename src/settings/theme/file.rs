//! Theme files: the shipped ones and the user's.

use std::path::Path;

use toml::Spanned;
use toml::de::DeValue;

use super::{ROLES, Theme, ThemeColor, ThemeFile};
use crate::TextFile;
use nearmiss_base::system::{TomlText, nearest, shown_value};

const SHIPPED: &[(&str, &str)] = &[
    ("dark", include_str!("../../../themes/dark.toml")),
    ("light", include_str!("../../../themes/light.toml")),
    (
        "contrast-dark",
        include_str!("../../../themes/contrast-dark.toml"),
    ),
    (
        "contrast-light",
        include_str!("../../../themes/contrast-light.toml"),
    ),
    (
        "colorblind-dark",
        include_str!("../../../themes/colorblind-dark.toml"),
    ),
    (
        "colorblind-light",
        include_str!("../../../themes/colorblind-light.toml"),
    ),
];

/// The name that stands for dark or light, as the terminal's background is.
pub const AUTO: &str = "auto";

/// Names that stand for one of two themes: for dark and for light backgrounds.
const PAIRS: [(&str, [&str; 2]); 3] = [
    (AUTO, ["dark", "light"]),
    ("contrast", ["contrast-dark", "contrast-light"]),
    ("colorblind", ["colorblind-dark", "colorblind-light"]),
];

/// A theme that can be chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedTheme<C> {
    /// By what name.
    pub name: String,
    /// The user's file; `None` for a shipped theme.
    pub file: Option<String>,
    /// The theme in all colours, or every mistake in its file.
    pub theme: Result<Theme<C>, Vec<String>>,
}

impl<C> NamedTheme<C> {
    /// The theme that `name` stands for on a dark or a light background. A file of the user's comes before a name that
    /// stands for two.
    #[must_use]
    pub fn find<'a>(all: &'a [Self], name: &str, dark: bool) -> Option<&'a Self> {
        let called = |name: &str| all.iter().find(|named| named.name == name);
        let pair = PAIRS.iter().find(|(both, _)| *both == name);
        called(name).or_else(|| called(pair?.1[usize::from(!dark)]))
    }
}

impl ThemeFile {
    /// Names that stand for a dark and a light theme, of which the terminal's background chooses.
    pub fn pairs() -> impl Iterator<Item = &'static str> {
        PAIRS.iter().map(|(name, _)| *name)
    }

    /// Names of the themes that come with the program.
    pub fn shipped() -> impl Iterator<Item = &'static str> {
        SHIPPED.iter().map(|(name, _)| *name)
    }

    /// Every theme that can be chosen: the shipped ones, in whose place a file of the user's may be, and the user's.
    #[must_use]
    pub fn all(folder: &Path) -> Vec<NamedTheme<ThemeColor>> {
        let mut all: Vec<NamedTheme<ThemeColor>> = SHIPPED
            .iter()
            .map(|(name, text)| NamedTheme {
                name: (*name).into(),
                file: None,
                theme: Self::parse(name, &format!("the shipped {name}.toml"), text),
            })
            .collect();
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut own: Vec<NamedTheme<ThemeColor>> =
            files.filter_map(|entry| own(&entry.path())).collect();
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
        Self::parse(name, name, text).unwrap_or_else(|_| Self::plain(ThemeColor::Terminal))
    }

    /// Reads a theme; roles that the file leaves out are as in the default theme for that background, except the
    /// background itself, which is then the terminal's.
    ///
    /// # Errors
    /// Every mistake, with file, line and key.
    pub fn parse(name: &str, file: &str, text: &str) -> Result<Self, Vec<String>> {
        let mut read = Reading {
            text: TomlText::new(text),
            dark: None,
            roles: Vec::new(),
            sixteen: Vec::new(),
        };
        read.file();
        let Reading {
            text,
            dark,
            roles,
            sixteen,
        } = read;
        text.checked(file)?;
        let dark = dark.unwrap_or(true);
        let complete = ROLES
            .iter()
            .all(|role| roles.iter().any(|(r, _)| r == role));
        let mut theme = if complete {
            Self::plain(ThemeColor::Terminal)
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
        let said = |name: &str| roles.iter().any(|(role, _)| *role == name);
        let (background, ground) = (said("background"), said("map_ground"));
        for (role, color) in roles {
            if let Some(place) = theme.role_mut(role) {
                *place = color;
            }
        }
        // The background of the default theme is not that of these colours: what is not painted stays the terminal's.
        if !background {
            theme.background = ThemeColor::Terminal;
        }
        if !ground {
            theme.map_ground = theme.background;
        }
        Ok(theme)
    }
}

/// What a file says, as far as it has been read.
struct Reading<'a> {
    text: TomlText<'a>,
    dark: Option<bool>,
    roles: Vec<(&'static str, ThemeColor)>,
    sixteen: Vec<(&'static str, ThemeColor)>,
}

impl Reading<'_> {
    fn file(&mut self) {
        let Some(table) = self.text.table() else {
            return;
        };
        for (key, value) in &table {
            match key.get_ref().as_ref() {
                "name" if value.get_ref().is_str() => {}
                "name" => self.text.mistake(&key.span(), "name must be a text".into()),
                "dark" => match value.get_ref().as_bool() {
                    Some(is) => self.dark = Some(is),
                    None => self
                        .text
                        .mistake(&key.span(), "dark must be true or false".into()),
                },
                part @ ("roles" | "sixteen") => {
                    for (role, value) in self.text.below(part, value).into_iter().flatten() {
                        self.role(part, role, value);
                    }
                }
                other => self.text.mistake(
                    &key.span(),
                    format!("unknown key `{other}`; available: name, dark, [roles], [sixteen]"),
                ),
            }
        }
        if !table.contains_key("dark") {
            let words = "dark is missing: set true for dark backgrounds, else false";
            self.text.mistake(&(0..0), words.into());
        }
    }

    fn role(&mut self, part: &str, role: &Spanned<impl AsRef<str>>, value: &Spanned<DeValue<'_>>) {
        let name = role.get_ref().as_ref();
        let Some(known) = ROLES.iter().find(|known| **known == name) else {
            let meant = nearest(name, ROLES.iter().copied())
                .map_or(String::new(), |role| format!("; did you mean `{role}`?"));
            let words = format!("unknown role `{part}.{name}`{meant}");
            return self.text.mistake(&role.span(), words);
        };
        let color = color_of(value.get_ref());
        let (list, few, needed) = match part {
            "roles" => (
                &mut self.roles,
                false,
                "a colour: \"#rrggbb\", a name such as \"red\", 0 to 255, or \"none\"",
            ),
            _ => (
                &mut self.sixteen,
                true,
                "one of the sixteen colours, such as \"red\" or \"lightred\"",
            ),
        };
        let fits = |color: &ThemeColor| {
            !few || matches!(color, ThemeColor::Ansi(_) | ThemeColor::Terminal)
        };
        match color.filter(fits) {
            Some(color) => list.push((*known, color)),
            None => {
                let shown = shown_value(value.get_ref());
                let words = format!("{part}.{name} = {shown} is not {needed}");
                self.text.mistake(&value.span(), words);
            }
        }
    }
}

/// A file of the user's, if it is a theme by its name.
fn own(path: &Path) -> Option<NamedTheme<ThemeColor>> {
    let name = path
        .file_name()?
        .to_str()?
        .strip_suffix(".toml")?
        .to_string();
    let theme = TextFile::read(path)
        .map_err(|error| vec![error])
        .and_then(|said| ThemeFile::parse(&name, &said.file, &said.text));
    Some(NamedTheme {
        name,
        file: Some(path.display().to_string()),
        theme,
    })
}

fn color_of(value: &DeValue<'_>) -> Option<ThemeColor> {
    match value {
        DeValue::Integer(index) => index.as_str().parse().ok().map(ThemeColor::Indexed),
        DeValue::String(text) => ThemeColor::parse(text),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn shipped_themes_give_every_role_at_every_depth() {
        for (name, text) in SHIPPED {
            for role in ROLES {
                let line = format!("\n{role} = ");
                assert!(text.contains(&line), "{name}: {role}");
            }
            let theme = ThemeFile::parse(name, name, text).unwrap();
            for role in ROLES {
                assert_ne!(
                    theme.role(role),
                    Some(ThemeColor::Terminal),
                    "{name}: {role}"
                );
            }
        }
    }

    #[test]
    fn mistakes_are_named_by_line_and_key() {
        let text = "name = \"mine\"\ndark = true\nbright = 1\n[roles]\ntext = \"blurple\"\ndangr = \"red\"\ndim = 300\n\n[sixteen]\ntext = \"#ffffff\"\n";
        let mistakes = ThemeFile::parse("mine", "mine.toml", text).unwrap_err();
        let found = [
            "mine.toml:3: unknown key `bright`",
            "mine.toml:5: roles.text = \"blurple\" is not a colour",
            "mine.toml:6: unknown role `roles.dangr`; did you mean `danger`?",
            "mine.toml:7: roles.dim = 300",
            "mine.toml:10: sixteen.text",
        ];
        assert_eq!(mistakes.len(), found.len(), "{mistakes:#?}");
        for (mistake, start) in mistakes.iter().zip(found) {
            assert!(mistake.starts_with(start), "{mistake}");
        }
        let broken =
            ThemeFile::parse("mine", "mine.toml", "name = \"mine\"\ndark = \n").unwrap_err();
        assert!(broken[0].starts_with("mine.toml:2: "), "{broken:?}");
    }

    #[test]
    fn roles_left_out_are_the_default_ones() {
        let theme = ThemeFile::parse("mine", "f", "dark = false\n[roles]\ntext = 160\n").unwrap();
        let light = ThemeFile::default_for(false);
        assert_eq!(theme.text, ThemeColor::Indexed(160));
        assert_eq!((theme.danger, &theme.name[..]), (light.danger, "mine"));
        // Black among the sixteen stands for the default's text, not for this one.
        let few = |theme: &ThemeFile, role| theme.sixteen.iter().any(|(own, _)| *own == role);
        assert!(few(&light, "text") && !few(&theme, "text"));
        assert!(few(&theme, "danger") == few(&light, "danger"));
        let grounds = |theme: &ThemeFile| (theme.background, theme.map_ground);
        assert_eq!(
            grounds(&theme),
            (ThemeColor::Terminal, ThemeColor::Terminal)
        );
        assert_eq!(theme.map_road, light.map_road);
    }

    #[test]
    fn files_come_before_shipped_themes_of_their_name() {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("dark.toml", "dark = true\n[roles]\ntext = \"red\"\n");
        write("mine.toml", "dark = true\n[roles]\ntext = 3.5\n");
        write("notes.txt", "no theme");
        let all = ThemeFile::all(folder.path());
        let theme = |name: &str| {
            let named = all.iter().find(|named| named.name == name).unwrap();
            named.theme.clone()
        };
        assert_eq!(theme("dark").unwrap().text, ThemeColor::Ansi(1));
        assert!(theme("mine").unwrap_err()[0].contains("mine.toml:3: roles.text"));
        let names: Vec<&str> = all.iter().map(|n| n.name.as_str()).collect();
        let shipped: Vec<&str> = ThemeFile::shipped().collect();
        assert_eq!(names[..6], shipped);
        assert_eq!(names[6..], ["mine"]);
        for name in ThemeFile::pairs() {
            for dark in [true, false] {
                let found = NamedTheme::find(&all, name, dark).unwrap();
                assert_eq!(found.theme.as_ref().unwrap().dark, dark, "{name}");
            }
        }
        // A file of that name is what the name means.
        write("contrast.toml", "dark = true\n[roles]\ntext = \"red\"\n");
        let all = ThemeFile::all(folder.path());
        let found = NamedTheme::find(&all, "contrast", false).unwrap();
        assert!(found.file.is_some());
    }
}
