//! Colours by role, for the terminal and for pictures alike: themes, shipped and in files of the user.

use std::path::Path;

use nearmiss_base::system::{TomlText, nearest, shown_value};
use toml::Spanned;
use toml::de::DeValue;

use super::TextFile;

/// A colour of a theme file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThemeColor {
    /// Red, green and blue, 0 to 255.
    Rgb(u8, u8, u8),
    /// One of the 256 colours of terminals.
    Indexed(u8),
    /// One of the sixteen named colours, by its ANSI number.
    Ansi(u8),
    /// The terminal's own.
    Terminal,
}

/// The sixteen named colours, in the order of their ANSI numbers.
const NAMES: [&str; 16] = [
    "black",
    "red",
    "green",
    "yellow",
    "blue",
    "magenta",
    "cyan",
    "gray",
    "darkgray",
    "lightred",
    "lightgreen",
    "lightyellow",
    "lightblue",
    "lightmagenta",
    "lightcyan",
    "white",
];

fn is_hex(digits: &&str) -> bool {
    digits.len() == 6 && digits.chars().all(|c| c.is_ascii_hexdigit())
}

impl ThemeColor {
    /// The colour that a word means: `#rrggbb`, a name such as `light-red`, a number up to 255, or `none`
    /// (`reset`, `terminal`).
    #[must_use]
    pub fn parse(word: &str) -> Option<Self> {
        let name = word
            .to_lowercase()
            .replace([' ', '-', '_'], "")
            .replace("bright", "light")
            .replace("grey", "gray");
        let name = match name.as_str() {
            "reset" | "none" | "terminal" => return Some(Self::Terminal),
            "silver" => "gray",
            "lightblack" => "darkgray",
            "lightwhite" | "lightgray" => "white",
            name => name,
        };
        if let Some(number) = NAMES.iter().position(|known| *known == name) {
            return u8::try_from(number).ok().map(Self::Ansi);
        }
        if let Ok(index) = word.parse() {
            return Some(Self::Indexed(index));
        }
        let digits = word.strip_prefix('#').filter(is_hex)?;
        let [_, red, green, blue] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
        Some(Self::Rgb(red, green, blue))
    }
}

/// A theme as its file says it.
pub type ThemeFile = Theme<ThemeColor>;

/// Makes [`Theme`] and the list of its roles from one list.
macro_rules! roles {
    ($($(#[$doc:meta])+ $role:ident,)+) => {
        /// A colour for every role.
        #[derive(Debug, Clone, PartialEq)]
        pub struct Theme<C> {
            /// What it is called.
            pub name: String,
            /// Whether it is made for dark backgrounds.
            pub dark: bool,
            /// Colours of roles for terminals with sixteen, where the nearest is not the best.
            pub sixteen: Vec<(&'static str, C)>,
            $($(#[$doc])+ pub $role: C,)+
        }

        /// Every role, in the order of the files.
        pub const ROLES: &[&str] = &[$(stringify!($role)),+];

        impl<C: Copy> Theme<C> {
            /// One colour for everything.
            #[must_use]
            pub fn plain(color: C) -> Self {
                Self {
                    name: "plain".into(),
                    dark: true,
                    sixteen: Vec::new(),
                    $($role: color,)+
                }
            }

            /// The same theme in other terms of colours.
            #[must_use]
            pub fn map<D>(self, color: impl Fn(C) -> D) -> Theme<D> {
                let sixteen = self.sixteen.into_iter();
                Theme {
                    name: self.name,
                    dark: self.dark,
                    sixteen: sixteen.map(|(role, own)| (role, color(own))).collect(),
                    $($role: color(self.$role),)+
                }
            }

            /// The colour of a role by its name.
            #[must_use]
            pub fn role(&self, name: &str) -> Option<C> {
                match name {
                    $(stringify!($role) => Some(self.$role),)+
                    _ => None,
                }
            }

            /// The place of a role's colour, by its name.
            pub fn role_mut(&mut self, name: &str) -> Option<&mut C> {
                match name {
                    $(stringify!($role) => Some(&mut self.$role),)+
                    _ => None,
                }
            }
        }
    };
}

roles! {
    /// Behind everything; `"none"` leaves the terminal's own.
    background,
    /// Ordinary text.
    text,
    /// Text that matters less.
    dim,
    /// Titles of panes.
    title,
    /// Keys, links, what can be acted on.
    accent,
    /// Borders.
    border,
    /// The border of the pane that has the keys.
    border_focused,
    /// The bar behind the selected line.
    selection,
    /// The part of a plot that is judged.
    shade,
    /// The ego.
    ego,
    /// Moving obstacles.
    obstacle,
    /// Standing obstacles.
    static_obstacle,
    /// Trucks, buses and trains.
    truck,
    /// Bicycles and motorcycles.
    cycle,
    /// Pedestrians.
    pedestrian,
    /// Brake lights that are on.
    brake_light,
    /// Indicators that flash.
    indicator,
    /// The picked obstacle.
    picked,
    /// Collisions and risk scores 0 and 1; errors.
    danger,
    /// Near misses and risk scores 2 and 3, in the hue of `danger`.
    danger_medium,
    /// Risk scores 4 and 5.
    danger_low,
    /// Warnings.
    warning,
    /// Done, saved, free of mistakes.
    safe,
    /// Answers that agree, beside `=`.
    agree,
    /// Answers that disagree, beside `≠`.
    disagree,
    /// Solid lane borders.
    lane,
    /// Dashed lane borders.
    lane_dashed,
    /// Crosswalks.
    crosswalk,
    /// Where obstacles have been.
    trail,
    /// Where the ego has been.
    ego_trail,
    /// Goal lanelets.
    goal,
    /// Traffic lights that show red.
    light_red,
    /// Traffic lights that show amber, alone or with red.
    light_amber,
    /// Traffic lights that show green.
    light_green,
    /// Traffic signs.
    sign,
    /// Predicted and counterfactual paths.
    predicted,
    /// Sets of places where an obstacle may be.
    occupancy,
    /// The measuring tape.
    tape,
    /// The attacker of a variant, and its changed motion.
    attacker,
    /// The map beside the roads, where it is drawn as surfaces.
    map_ground,
    /// The surface of roads.
    map_road,
    /// The surface of intersections.
    map_junction,
    /// Pavements and lanes for bicycles.
    map_path,
    /// Lane markings on the surface of roads.
    map_marking,
}

const SHIPPED: &[(&str, &str)] = &[
    ("dark", include_str!("../../themes/dark.toml")),
    ("light", include_str!("../../themes/light.toml")),
    (
        "contrast-dark",
        include_str!("../../themes/contrast-dark.toml"),
    ),
    (
        "contrast-light",
        include_str!("../../themes/contrast-light.toml"),
    ),
    (
        "colorblind-dark",
        include_str!("../../themes/colorblind-dark.toml"),
    ),
    (
        "colorblind-light",
        include_str!("../../themes/colorblind-light.toml"),
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
    fn words_of_colours() {
        for (word, color) in [
            ("#0a14ff", ThemeColor::Rgb(10, 20, 255)),
            ("Light Red", ThemeColor::Ansi(9)),
            ("bright-red", ThemeColor::Ansi(9)),
            ("grey", ThemeColor::Ansi(7)),
            ("dark_grey", ThemeColor::Ansi(8)),
            ("160", ThemeColor::Indexed(160)),
            ("reset", ThemeColor::Terminal),
        ] {
            assert_eq!(ThemeColor::parse(word), Some(color), "{word}");
        }
        for word in ["", "blurple", "256", "#12345", "#12345g", "#+12345"] {
            assert_eq!(ThemeColor::parse(word), None, "{word}");
        }
    }

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
