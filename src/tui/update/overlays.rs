//! Keys in help, palette and the list of models.

use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher};

use super::super::action::{ACTIONS, Entry};
use super::super::keymap::{Code, Key};
use super::super::message::Effect;
use super::super::model::{Model, Overlay, Picker};
use super::{actions, answers};
use crate::judge;

/// A key while an overlay is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    if key.code == Code::Esc {
        model.overlays.pop();
        return Vec::new();
    }
    let Some(overlay) = model.overlays.last_mut() else {
        return Vec::new();
    };
    if let Overlay::Help { scroll } = overlay {
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
        Some(Overlay::Models { picker, .. }) => models_shown(model, picker).len(),
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
        Overlay::Palette(picker) | Overlay::Models { picker, .. } => Some(picker),
        Overlay::Help { .. } => None,
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
        Some(Overlay::Models { picker, ask }) => {
            let Some(id) = models_shown(model, &picker)
                .into_iter()
                .nth(picker.selected)
            else {
                return Vec::new();
            };
            model.model.clone_from(&id);
            if ask {
                return answers::ask(model);
            }
            model.say(format!("r asks {id}"));
            Vec::new()
        }
        _ => Vec::new(),
    }
}

/// The actions that a palette shows, the best match first.
#[must_use]
pub fn palette_shown(picker: &Picker) -> Vec<&'static Entry> {
    let texts = ACTIONS.iter().map(|e| format!("{} {}", e.id, e.doc));
    matching(&picker.text, texts)
        .into_iter()
        .map(|i| &ACTIONS[i])
        .collect()
}

/// The models that the list shows, the best match first; what is typed can be one of its own.
#[must_use]
pub fn models_shown(model: &Model, picker: &Picker) -> Vec<String> {
    let mut ids = vec![judge::MODEL.to_string()];
    ids.extend(model.offers.iter().map(|o| o.id.clone()));
    let order = matching(&picker.text, ids.iter().cloned());
    let mut shown: Vec<String> = order.into_iter().map(|i| ids[i].clone()).collect();
    let typed = picker.text.trim();
    let named = typed
        .split_once('/')
        .is_some_and(|(p, m)| !p.is_empty() && !m.is_empty());
    if named && !shown.iter().any(|id| id == typed) {
        shown.push(typed.to_string());
    }
    shown
}

/// Places of the texts that match, the best first; all of them for an empty pattern.
fn matching(pattern: &str, texts: impl Iterator<Item = String>) -> Vec<usize> {
    let mut matcher = Matcher::new(Config::DEFAULT);
    let parsed = Pattern::parse(pattern, CaseMatching::Smart, Normalization::Smart);
    let mut buffer = Vec::new();
    let mut scored: Vec<(u32, usize)> = texts
        .enumerate()
        .filter_map(|(i, text)| {
            let text = nucleo_matcher::Utf32Str::new(&text, &mut buffer);
            parsed.score(text, &mut matcher).map(|score| (score, i))
        })
        .collect();
    if !pattern.is_empty() {
        scored.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    }
    scored.into_iter().map(|(_, i)| i).collect()
}
