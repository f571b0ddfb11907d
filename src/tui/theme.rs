//! Colours by role, from a file; how many of them the terminal has.

mod ansi;
mod color;
mod depth;
mod file;
mod preview;
#[cfg(test)]
mod sight;

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Line;

pub use depth::Depth;
pub use file::{AUTO, Named};
pub use preview::preview;

/// Makes [`Theme`] and the list of its roles from one list.
macro_rules! roles {
    ($($(#[$doc:meta])+ $role:ident,)+) => {
        /// A colour for every role.
        #[derive(Debug, Clone, PartialEq)]
        pub struct Theme {
            /// What it is called.
            pub name: String,
            /// Whether it is made for dark backgrounds.
            pub dark: bool,
            /// Colours of roles for terminals with sixteen, where the nearest is not the best.
            sixteen: Vec<(&'static str, Color)>,
            $($(#[$doc])+ pub $role: Color,)+
        }

        /// Every role, in the order of the files.
        pub const ROLES: &[&str] = &[$(stringify!($role)),+];

        impl Theme {
            /// The terminal's own colour for everything.
            fn plain() -> Self {
                Self {
                    name: "plain".into(),
                    dark: true,
                    sixteen: Vec::new(),
                    $($role: Color::Reset,)+
                }
            }

            /// The colour of a role by its name.
            #[must_use]
            pub fn role(&self, name: &str) -> Option<Color> {
                match name {
                    $(stringify!($role) => Some(self.$role),)+
                    _ => None,
                }
            }

            fn role_mut(&mut self, name: &str) -> Option<&mut Color> {
                match name {
                    $(stringify!($role) => Some(&mut self.$role),)+
                    _ => None,
                }
            }
        }
    };
}

roles! {
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
    /// The ego.
    ego,
    /// Moving obstacles.
    obstacle,
    /// Standing obstacles.
    static_obstacle,
    /// The picked obstacle.
    picked,
    /// Collisions, errors, disagreement.
    danger,
    /// Near misses, warnings.
    warning,
    /// Safe, agreement.
    safe,
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
}

impl Theme {
    /// The same theme for a terminal with fewer colours.
    #[must_use]
    pub fn at_depth(mut self, depth: Depth) -> Self {
        let sixteen = std::mem::take(&mut self.sixteen);
        let dark = self.dark;
        for name in ROLES {
            let own = sixteen.iter().find(|(role, _)| role == name);
            if let Some(role) = self.role_mut(name) {
                *role = match (depth, own) {
                    (Depth::Sixteen, Some((_, color))) => *color,
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
}
