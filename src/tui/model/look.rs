//! Appearance and keys of the workbench, changeable while it runs.

use nearmiss_render::cells::{Blocks, MapStyle};
use nearmiss_settings::{Config, ThemeFile};
use ratatui::layout::Position;

use crate::action::Action;
use crate::keymap::{Code, Key, Keymap, Preset};
use crate::model::{Border, Model, Picker, Sizes};
use crate::theme::{AUTO, ColorDepth, Named, Theme};

/// Symbols that the terminal supports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Glyphs {
    /// All of Unicode that the views use.
    Unicode,
    /// ASCII only.
    Ascii,
}

/// How the map is to be drawn, as configured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapChoice {
    /// As well as the terminal can.
    Auto,
    /// As an image.
    Pixels,
    /// Filled cells.
    Cells,
    /// Braille lines and solid bodies, without backgrounds.
    Braille,
    /// ASCII.
    Ascii,
}

impl MapChoice {
    /// All with their names in the configuration.
    pub const NAMED: [(&str, Self); 5] = [
        ("auto", Self::Auto),
        ("pixels", Self::Pixels),
        ("cells", Self::Cells),
        ("braille", Self::Braille),
        ("ascii", Self::Ascii),
    ];

    /// As configured; a name that is not known was refused when the file was read.
    #[must_use]
    pub fn of_config(name: Option<&str>) -> Self {
        let named = Self::NAMED.iter().find(|(n, _)| Some(*n) == name);
        named.map_or(Self::Auto, |(_, choice)| *choice)
    }
}

/// Appearance and keys.
#[derive(Debug)]
pub struct DisplaySettings {
    /// The live keymap.
    pub keymap: Keymap,
    /// Keys of a chord that were pressed so far.
    pub pending: Vec<Key>,
    /// The digits that were typed before a motion so far.
    pub count: Option<u32>,
    /// The count of the action that is being performed.
    pub repeat: Option<u32>,
    /// The name of the theme that is chosen; `auto` for dark or light.
    pub chosen: String,
    /// The configuration file, as it is told.
    pub config_file: String,
    /// The themes that can be chosen, in all colours.
    pub themes: Vec<Named>,
    /// How many colours the terminal has.
    pub depth: ColorDepth,
    /// Whether its background is dark.
    pub dark: bool,
    /// Which signs it can show.
    pub glyphs: Glyphs,
    /// The same for `glyphs = "auto"`, as the environment has it.
    pub glyphs_here: Glyphs,
    /// How the map is to be drawn.
    pub map: MapChoice,
    /// The block characters of the map.
    pub blocks: Blocks,
    /// The same for `map_blocks = "auto"`, as the environment has it.
    pub blocks_here: Blocks,
    /// Whether this is tmux, which takes octants for two columns wide.
    pub in_tmux: bool,
    /// How big the panes are.
    pub sizes: Sizes,
    /// The border that the mouse holds, as it was when it was taken, and where.
    pub held: Option<(Border, Position)>,
}

impl DisplaySettings {
    /// How the map is drawn: as configured, else what the terminal can show.
    #[must_use]
    pub fn map_style(&self) -> MapStyle {
        match (self.map, self.glyphs) {
            (MapChoice::Ascii, _) | (_, Glyphs::Ascii) => MapStyle::Ascii,
            (MapChoice::Braille, _) => MapStyle::Braille,
            (MapChoice::Auto | MapChoice::Pixels, _) if self.depth == ColorDepth::None => {
                MapStyle::Braille
            }
            _ => MapStyle::Cells(self.blocks),
        }
    }
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self {
            keymap: Keymap::from_preset(Preset::Default),
            pending: Vec::new(),
            count: None,
            repeat: None,
            chosen: AUTO.into(),
            config_file: "config.toml".into(),
            themes: Vec::new(),
            depth: ColorDepth::True,
            dark: true,
            glyphs: Glyphs::Unicode,
            glyphs_here: Glyphs::Unicode,
            map: MapChoice::Auto,
            blocks: Blocks::Quadrants,
            blocks_here: Blocks::Quadrants,
            in_tmux: false,
            sizes: Sizes::default(),
            held: None,
        }
    }
}

impl Glyphs {
    /// What the environment says: ASCII where the locale is not UTF-8 or the screen is the Linux console, whose fonts
    /// have neither Braille nor thick borders. An environment without a locale is taken for UTF-8.
    #[must_use]
    pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Self {
        let says = |name: &str| env(name).filter(|value| !value.is_empty());
        let locale = ["LC_ALL", "LC_CTYPE", "LANG"]
            .iter()
            .find_map(|name| says(name));
        let utf8 = locale.is_none_or(|l| {
            let l = l.to_lowercase();
            l.contains("utf-8") || l.contains("utf8")
        });
        if utf8 && says("TERM").as_deref() != Some("linux") {
            Self::Unicode
        } else {
            Self::Ascii
        }
    }

    /// The configured value; `here` if it leaves that to the environment.
    #[must_use]
    pub fn of_config(said: Option<&str>, here: Self) -> Self {
        match said {
            Some("ascii") => Self::Ascii,
            Some("unicode") => Self::Unicode,
            _ => here,
        }
    }
}

impl DisplaySettings {
    /// Takes over how the map is to be drawn.
    pub fn configure_map(&mut self, config: &Config) {
        let blocks = config.map_blocks.as_deref();
        let is_drawn = |blocks| !(self.in_tmux && blocks == Blocks::Octants);
        let mut named = Blocks::NAMED.iter();
        let named = named.find(|(name, named)| Some(*name) == blocks && is_drawn(*named));
        self.blocks = named.map_or(self.blocks_here, |(_, blocks)| *blocks);
        self.map = MapChoice::of_config(config.map.as_deref());
    }

    /// The theme of this name as the terminal can show it.
    ///
    /// # Errors
    /// The theme does not exist, or its file is invalid.
    pub fn theme(&self, name: &str) -> Result<Theme, String> {
        match Named::find(&self.themes, name, self.dark).map(|named| &named.theme) {
            Some(Ok(theme)) => Ok(Theme(theme.clone()).at_depth(self.depth)),
            Some(Err(mistakes)) => Err(crate::keymap::first_mistake(mistakes)),
            None => Err(format!("theme `{name}` no longer exists")),
        }
    }

    /// Whether a chord of the menus behind the space bar has begun.
    #[must_use]
    pub fn in_menu(&self) -> bool {
        self.pending.first() == Some(&Key::plain(Code::Char(' ')))
    }

    /// How often the motion that is being performed is repeated.
    #[must_use]
    pub fn times(&self) -> i64 {
        self.repeat.map_or(1, i64::from)
    }

    /// How far the action that is being performed moves a list, lines down, where a page has so many.
    #[must_use]
    pub fn lines(&self, action: Action, page: isize) -> isize {
        let times = isize::try_from(self.times()).unwrap_or(1);
        action.lines(page).saturating_mul(times)
    }

    /// The line that a count names for going to the top or the bottom, from 0.
    #[must_use]
    pub fn line(&self, action: Action) -> Option<usize> {
        let goes = matches!(action, Action::Top | Action::Bottom);
        let line = self.repeat.filter(|_| goes)?.saturating_sub(1);
        usize::try_from(line).ok()
    }

    /// The key of an action, for a sentence.
    #[must_use]
    pub fn key(&self, action: Action) -> String {
        self.keymap.key_of(action)
    }
}

/// The names of the themes that the list shows, the best match first; those that cannot be used are in it too.
#[must_use]
pub fn themes_shown(model: &Model, picker: &Picker) -> Vec<String> {
    let files: Vec<String> = model.look.themes.iter().map(|n| n.name.clone()).collect();
    let pairs = ThemeFile::pairs().map(String::from);
    let mut names: Vec<String> = pairs.filter(|pair| !files.contains(pair)).collect();
    names.extend(files);
    let order = super::picker::matching(&picker.text, names.iter().cloned());
    order.into_iter().map(|i| names[i].clone()).collect()
}

impl Model {
    /// Whether an ego may come by itself.
    #[must_use]
    pub fn awaits_ego(&self) -> bool {
        self.opened.is_none() || self.driver.under_way.is_some()
    }

    /// Why there is nothing to judge or plot, and what to do.
    #[must_use]
    pub fn without_ego(&self) -> String {
        let why = self.opened.as_ref().map(|o| o.no_ego.as_ref());
        match why {
            None => "no scenario is open".into(),
            Some(_) if self.driver.under_way.is_some() => "the ego is being planned".into(),
            Some(why) => {
                let why = why.map_or("there is no ego".to_string(), ToString::to_string);
                let key = |action| self.look.key(action);
                let scenario = self.opened.as_ref().map(|o| &o.scenario);
                let takes = scenario.filter(|s| !s.obstacles.is_empty()).map(|_| {
                    let (pick, take) = (key(Action::NextObstacle), key(Action::TakeAsEgo));
                    format!("{pick} picks an obstacle, {take} makes it the ego")
                });
                let plans = scenario
                    .filter(|s| !s.planning_problems.is_empty())
                    .map(|_| format!("{} lets the planner drive one", key(Action::DrivePlanner)));
                let ways: Vec<String> = takes.into_iter().chain(plans).collect();
                if ways.is_empty() {
                    format!("{why}, and no obstacle that could be one")
                } else {
                    format!("{why}: {}", ways.join(", "))
                }
            }
        }
    }

    /// Shows the theme of this name.
    ///
    /// # Errors
    /// It cannot be used; what was shown stays.
    pub fn show_theme(&mut self, name: &str) -> Result<(), String> {
        self.theme = self.look.theme(name)?;
        Ok(())
    }
}

impl Model {
    /// The present state of what an action switches, in a word; `None` for actions that switch nothing.
    #[must_use]
    pub fn state_of(&self, action: Action) -> Option<&str> {
        let is = |on: bool| Some(if on { "on" } else { "off" });
        let techniques = self.decided().techniques;
        match action {
            Action::ToggleTask => Some(self.task.name()),
            Action::ToggleFrame => Some(self.frame.name()),
            Action::ToggleCp => is(techniques.cp),
            Action::ToggleCot => is(techniques.cot),
            Action::ToggleIcl => is(techniques.icl),
            Action::ToggleTools => is(self.tools),
            Action::PromptView => Some(self.prompt.view.name()),
            Action::Follow => is(self.camera.follow),
            Action::EgoUp if !self.camera.ego_up => Some("north up"),
            Action::EgoUp => Some("on"),
            Action::Mouse => is(self.mouse),
            Action::GroupScenarios => Some(self.list.grouping.name()),
            Action::NextForecast => Some(self.driver.forecast.name()),
            Action::NextPlanner => Some(self.driver.planner_name()),
            Action::PlotMeasure => Some(self.plot.measure.id),
            Action::PickTheme => Some(&self.look.chosen),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_says_which_signs() {
        let of = |pairs: &[(&str, &str)]| {
            Glyphs::of_environment(|name| {
                let pair = pairs.iter().find(|(n, _)| *n == name);
                pair.map(|(_, value)| (*value).to_string())
            })
        };
        assert_eq!(of(&[]), Glyphs::Unicode);
        assert_eq!(of(&[("LANG", "de_DE.UTF-8")]), Glyphs::Unicode);
        assert_eq!(of(&[("LANG", "C.utf8")]), Glyphs::Unicode);
        assert_eq!(of(&[("LANG", "C")]), Glyphs::Ascii);
        assert_eq!(
            of(&[("LC_ALL", "POSIX"), ("LANG", "de_DE.UTF-8")]),
            Glyphs::Ascii
        );
        assert_eq!(
            of(&[("LC_ALL", ""), ("LANG", "de_DE.UTF-8")]),
            Glyphs::Unicode
        );
        assert_eq!(
            of(&[("TERM", "linux"), ("LANG", "de_DE.UTF-8")]),
            Glyphs::Ascii
        );
        assert_eq!(
            Glyphs::of_config(Some("unicode"), Glyphs::Ascii),
            Glyphs::Unicode
        );
        assert_eq!(Glyphs::of_config(None, Glyphs::Ascii), Glyphs::Ascii);
    }
}
