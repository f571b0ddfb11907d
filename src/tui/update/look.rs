//! Reloaded theme and keymap files: an invalid file leaves the last valid one in force.

use super::super::message::Reloaded;
use super::super::model::{Glyphs, Model};
use nearmiss_settings::Config;

/// A file was changed.
pub fn reloaded(model: &mut Model, what: Reloaded) {
    match what {
        Reloaded::Config(Ok(config)) => configured(model, &config),
        Reloaded::Config(Err(error)) => {
            model.complain(format!("{error}; what was set stays"));
        }
        Reloaded::Keymap(Ok(keymap)) => {
            if model.look.keymap != keymap {
                let notes = keymap.notes.clone();
                model.look.keymap = keymap;
                model.look.pending.clear();
                model.look.count = None;
                model.say("the keys of keymap.toml are in use");
                notes.into_iter().for_each(|note| model.tell(note));
            }
        }
        Reloaded::Keymap(Err(error)) => {
            model.complain(format!("{error}; the keys stay as they were"));
        }
        Reloaded::Themes(themes) => {
            model.look.themes = themes;
            if let Err(why) = model.show_theme(&model.look.chosen.clone()) {
                model.complain(format!("{why}; the colours stay as they were"));
            }
        }
    }
}

/// The configuration is read again for the look alone; the rest holds from the next start on.
fn configured(model: &mut Model, config: &Config) {
    model.look.configure_map(config);
    model.look.glyphs = Glyphs::of_config(config.glyphs.as_deref(), model.look.glyphs_here);
    let name = config.theme.clone().unwrap_or_else(|| "auto".into());
    if model.config.theme != config.theme {
        model.config.theme.clone_from(&config.theme);
        match model.look.theme(&name) {
            Ok(theme) => {
                model.look.chosen = name;
                model.theme = theme;
            }
            Err(why) => model.complain(format!("{why}; the colours stay as they were")),
        }
    }
    model.config.glyphs.clone_from(&config.glyphs);
    model.config.map.clone_from(&config.map);
    model.config.map_blocks.clone_from(&config.map_blocks);
    if model.config != *config {
        model.say(
            "config.toml was changed: theme, glyphs and map apply now, the rest at the next start",
        );
    }
}
