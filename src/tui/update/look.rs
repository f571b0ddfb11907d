//! Themes that are chosen, and files that say how the workbench looks: what was good stays where the new is not.

use super::super::message::{Effect, Reloaded};
use super::super::model::{Glyphs, Model, Overlay, Picker, themes_shown};
use crate::settings::Config;

/// Opens the list of themes at the one that is chosen.
pub fn pick_theme(model: &mut Model) {
    let all = Picker::default();
    let shown = themes_shown(model, &all);
    let now = shown.iter().position(|name| *name == model.look.chosen);
    model.overlays.push(Overlay::Themes(Picker {
        selected: now.unwrap_or(0),
        ..all
    }));
}

/// Shows the selected theme, if it can be shown.
pub fn preview(model: &mut Model) {
    // Why it cannot be shown stands in the list.
    let _ = model.show_theme();
}

/// Takes the theme that was selected in the list, which is closed.
pub fn take(model: &mut Model, picker: &Picker) -> Vec<Effect> {
    let shown = themes_shown(model, picker);
    if let Some(name) = shown.get(picker.selected) {
        match model.look.theme(name) {
            Ok(theme) => {
                model.theme = theme;
                model.look.chosen.clone_from(name);
                let while_it_lasts = match model.recall.on {
                    true => "for this session",
                    false => "until you quit",
                };
                model.say(format!(
                    "{while_it_lasts}; `theme = {name:?}` in config.toml keeps it"
                ));
            }
            Err(why) => {
                model.complain(format!("the theme stays as it was: {why}"));
                preview(model);
            }
        }
    }
    Vec::new()
}

/// A file was changed.
pub fn reloaded(model: &mut Model, what: Reloaded) {
    match what {
        Reloaded::Config(Ok(config)) => configured(model, &config),
        Reloaded::Config(Err(error)) => {
            model.complain(format!("{error}; what was set stays"));
        }
        Reloaded::Keymap(Ok(keymap)) => {
            if model.look.keymap != keymap {
                model.look.keymap = keymap;
                model.look.pending.clear();
                model.say("the keys of keymap.toml are in use");
            }
        }
        Reloaded::Keymap(Err(error)) => {
            model.complain(format!("{error}; the keys stay as they were"));
        }
        Reloaded::Themes(themes) => {
            model.look.themes = themes;
            if let Err(why) = model.show_theme() {
                model.complain(format!("{why}; the colours stay as they were"));
            }
        }
    }
}

/// The configuration is read again for the look alone; the rest holds from the next start on.
fn configured(model: &mut Model, config: &Config) {
    model.look.glyphs = Glyphs::of_config(config.glyphs.as_deref(), model.look.glyphs_here);
    let name = config.theme.clone().unwrap_or_else(|| "auto".into());
    if model.config.theme != config.theme {
        model.config.theme.clone_from(&config.theme);
        match model.look.theme(&name) {
            Ok(_) => {
                model.look.chosen = name;
                preview(model);
            }
            Err(why) => model.complain(format!("{why}; the colours stay as they were")),
        }
    }
    model.config.glyphs.clone_from(&config.glyphs);
    if model.config != *config {
        model.say(
            "config.toml was changed: theme and glyphs at once, the rest from the next start on",
        );
    }
}
