//! Colours by role: a theme as its file says it, for the terminal and for pictures alike.

mod file;

pub use file::{AUTO, NamedTheme};

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
    /// Near misses and risk score 2, in the hue of `danger`.
    danger_medium,
    /// Risk scores 3 to 5.
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

#[cfg(test)]
mod tests {
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
}
