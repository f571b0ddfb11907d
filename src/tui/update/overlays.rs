//! Keys in help, palette and the lists of models and measures.

use super::super::action::{Action, Scope};
use super::super::keymap::{Code, Key};
use super::super::message::Effect;
use super::super::model::{
    Model, Overlay, Picker, measures_shown, models_shown, orders_shown, palette_shown,
    pictures_shown, templates_shown, themes_shown,
};
use super::line::edit;
use super::{
    actions, answers, batch, editing, history, jobs, list, look, making, map, picture, planning,
    plot, results, source, values,
};

/// A key while an overlay is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match model.overlays.last() {
        Some(Overlay::History) => return history::on_key(model, key),
        Some(Overlay::Jobs) => return jobs::on_key(model, key),
        Some(Overlay::Batch) => return batch::on_key(model, key),
        Some(Overlay::Results) => return results::on_key(model, key),
        _ => {}
    }
    if key.code == Code::Esc {
        return actions::cancel(model);
    }
    if matches!(model.overlays.last(), Some(Overlay::Values { .. }))
        && let Some(effects) = values::on_key(model, key)
    {
        return effects;
    }
    if matches!(model.overlays.last(), Some(Overlay::Source { .. }))
        && let Some(effects) = source::on_key(model, key)
    {
        return effects;
    }
    if matches!(model.overlays.last(), Some(Overlay::Layers(_))) {
        map::layers_key(model, key);
        return Vec::new();
    }
    if matches!(model.overlays.last(), Some(Overlay::Details(_)))
        && let Some(effects) = map::details_key(model, key)
    {
        return effects;
    }
    if matches!(model.overlays.last(), Some(Overlay::Cycle(_)))
        && let Some(effects) = planning::cycle_key(model, key)
    {
        return effects;
    }
    if matches!(model.overlays.last(), Some(Overlay::Variant(_)))
        && let Some(effects) = making::panel_key(model, key)
    {
        return effects;
    }
    let asks_for_help = model.look.keymap.action(key, Scope::Global) == Some(Action::Help);
    let Some(overlay) = model.overlays.last_mut() else {
        return Vec::new();
    };
    if let Overlay::Help { scroll, text } = overlay {
        let closes = asks_for_help && text.is_empty();
        match key.code {
            _ if closes => drop(model.overlays.pop()),
            _ if edit(text, key) => *scroll = 0,
            Code::Up => *scroll = scroll.saturating_sub(1),
            Code::Down => *scroll += 1,
            Code::PageUp => *scroll = scroll.saturating_sub(10),
            Code::PageDown => *scroll += 10,
            _ => {}
        }
        return Vec::new();
    }
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
        match key.code {
            Code::Up => picker.selected = picker.selected.saturating_sub(1),
            Code::Down | Code::Tab => picker.selected += 1,
            _ if edit(&mut picker.text, key) => picker.selected = 0,
            _ => {}
        }
    }
    settle(model);
    if matches!(model.overlays.last(), Some(Overlay::Themes(_))) {
        look::preview(model);
    }
    Vec::new()
}

/// Keeps the selected line one of those that are listed: what is pasted or read again may leave fewer.
pub fn settle(model: &mut Model) {
    let lines = match model.overlays.last() {
        Some(Overlay::Palette(picker)) => palette_shown(picker).len(),
        Some(Overlay::Themes(picker)) => themes_shown(model, picker).len(),
        Some(Overlay::Pictures(picker)) => pictures_shown(picker, model.focus).len(),
        Some(Overlay::Models { picker, .. }) => models_shown(model, picker).len(),
        Some(Overlay::Measures { picker, sort: true }) => orders_shown(picker).len(),
        Some(Overlay::Measures { picker, .. }) => measures_shown(picker).len(),
        Some(Overlay::Templates { picker }) => templates_shown(model, picker).len(),
        _ => return,
    };
    if let Some(picker) = picker_mut(model) {
        picker.selected = picker.selected.min(lines.saturating_sub(1));
    }
}

/// Text that is pasted into the line of the overlay on top, or into that of a reason on the screen of answers side by
/// side.
pub fn paste(model: &mut Model, text: &str) {
    let line = editing::first_line(text);
    if let Some(Overlay::Help { scroll, text }) = model.overlays.last_mut() {
        text.push_str(&line);
        *scroll = 0;
    } else if let Some(picker) = picker_mut(model) {
        picker.text.push_str(&line);
        picker.selected = 0;
        if matches!(model.overlays.last(), Some(Overlay::Themes(_))) {
            look::preview(model);
        }
    } else if let Some(marking) = model.compare.marking.as_mut()
        && model.overlays.is_empty()
    {
        marking.text.push_str(&line);
    }
}

/// The line that is typed into, if an overlay has one.
pub fn picker_mut(model: &mut Model) -> Option<&mut Picker> {
    match model.overlays.last_mut()? {
        Overlay::Palette(picker)
        | Overlay::Themes(picker)
        | Overlay::Pictures(picker)
        | Overlay::Models { picker, .. }
        | Overlay::Measures { picker, .. }
        | Overlay::Templates { picker }
        | Overlay::Tags { picker, .. } => Some(picker),
        Overlay::Help { .. }
        | Overlay::About { .. }
        | Overlay::Values { .. }
        | Overlay::Source { .. }
        | Overlay::Details(_)
        | Overlay::Cycle(_)
        | Overlay::Variant(_)
        | Overlay::Layers(_)
        | Overlay::History
        | Overlay::Jobs
        | Overlay::Results
        | Overlay::Batch => None,
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
        Some(Overlay::Themes(picker)) => look::take(model, &picker),
        Some(Overlay::Pictures(picker)) => picture::chosen(model, &picker),
        Some(Overlay::Measures { picker, sort: true }) => {
            match orders_shown(&picker).get(picker.selected) {
                Some(order) => list::sort(model, *order),
                None => Vec::new(),
            }
        }
        Some(Overlay::Measures { picker, .. }) => {
            if let Some(measure) = measures_shown(&picker).get(picker.selected) {
                plot::plot(model, measure);
            }
            Vec::new()
        }
        Some(Overlay::Tags { picker, scenario }) => list::tag(model, scenario, &picker.text),
        Some(Overlay::Templates { picker }) => editing::use_template(model, &picker),
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
            let key = model.look.key(Action::Run);
            model.say(format!("{key} asks {id}"));
            Vec::new()
        }
        _ => Vec::new(),
    }
}
