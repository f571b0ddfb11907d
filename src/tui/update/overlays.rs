//! Keys in help, palette and the lists of models and measures.

use super::super::keymap::{Code, Key};
use super::super::message::Effect;
use super::super::model::{
    Model, Overlay, Picker, measures_shown, models_shown, palette_shown, pictures_shown,
};
use super::{actions, answers, picture, plot, values};

/// A key while an overlay is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    if key.code == Code::Esc {
        model.overlays.pop();
        return Vec::new();
    }
    if matches!(model.overlays.last(), Some(Overlay::Values { .. }))
        && let Some(effects) = values::on_key(model, key)
    {
        return effects;
    }
    let Some(overlay) = model.overlays.last_mut() else {
        return Vec::new();
    };
    if let Some(scroll) = overlay.scroll_mut() {
        match key.code {
            Code::Up | Code::Char('k') => *scroll = scroll.saturating_sub(1),
            Code::Down | Code::Char('j') => *scroll += 1,
            Code::PageUp => *scroll = scroll.saturating_sub(10),
            Code::PageDown | Code::Char(' ') => *scroll += 10,
            _ => {
                model.overlays.pop();
            }
        }
        return Vec::new();
    }
    if key.code == Code::Enter {
        return choose(model);
    }
    if let Some(picker) = picker_mut(model) {
        match (key.code, key.writes()) {
            (Code::Up, _) => picker.selected = picker.selected.saturating_sub(1),
            (Code::Down | Code::Tab, _) => picker.selected += 1,
            (Code::Backspace, _) => {
                picker.text.pop();
                picker.selected = 0;
            }
            (_, Some(c)) => {
                picker.text.push(c);
                picker.selected = 0;
            }
            _ => {}
        }
    }
    let lines = match model.overlays.last() {
        Some(Overlay::Palette(picker)) => palette_shown(picker).len(),
        Some(Overlay::Pictures(picker)) => pictures_shown(picker, model.focus).len(),
        Some(Overlay::Models { picker, .. }) => models_shown(model, picker).len(),
        Some(Overlay::Measures { picker, sort }) => measures_shown(picker, *sort).len(),
        _ => 0,
    };
    if let Some(picker) = picker_mut(model) {
        picker.selected = picker.selected.min(lines.saturating_sub(1));
    }
    Vec::new()
}

/// The line that is typed into, if an overlay has one.
pub fn picker_mut(model: &mut Model) -> Option<&mut Picker> {
    match model.overlays.last_mut()? {
        Overlay::Palette(picker)
        | Overlay::Pictures(picker)
        | Overlay::Models { picker, .. }
        | Overlay::Measures { picker, .. } => Some(picker),
        Overlay::Help { .. } | Overlay::About { .. } | Overlay::Values { .. } => None,
    }
}

fn choose(model: &mut Model) -> Vec<Effect> {
    match model.overlays.pop() {
        Some(Overlay::Palette(picker)) => {
            let shown = palette_shown(&picker);
            match shown.get(picker.selected) {
                Some(entry) => actions::perform(model, entry.action),
                None => Vec::new(),
            }
        }
        Some(Overlay::Pictures(picker)) => picture::chosen(model, &picker),
        Some(Overlay::Measures { picker, sort }) => {
            let shown = measures_shown(&picker, sort);
            match shown.get(picker.selected) {
                Some(measure) if sort => plot::sort(model, *measure),
                Some(Some(measure)) => {
                    plot::plot(model, measure);
                    Vec::new()
                }
                _ => Vec::new(),
            }
        }
        Some(Overlay::Models { picker, ask }) => {
            let Some(id) = models_shown(model, &picker)
                .into_iter()
                .nth(picker.selected)
            else {
                return Vec::new();
            };
            model.model.clone_from(&id);
            if ask {
                return answers::ask(model, false);
            }
            model.say(format!("r asks {id}"));
            Vec::new()
        }
        _ => Vec::new(),
    }
}
