//! Help: the keys of the live keymap, those of the focused pane first, with a filter.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use unicode_width::UnicodeWidthStr;

use crate::action::{ACTIONS, Action, Entry, Scope, order_of, synonyms_of, title_of};
use crate::features::{PAGE, Screen, Step};
use crate::keymap::{Chord, Code, Key, edit_line, first_line};
use crate::message::Effect;
use crate::model::{Model, TERMS};
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::window;
use crate::widgets::words::{fit, pad};

/// Columns of the keys at least, and at most.
const KEYS: (usize, usize) = (16, 22);

/// All keys that match the filter.
#[derive(Debug, Default)]
pub struct HelpScreen {
    /// The filter text.
    pub typed: String,
    scroll: usize,
    /// The keys of the window that it was opened over.
    window: Vec<Hint>,
}

/// Opens it over what is open.
pub fn open(model: &mut Model) {
    let top = model
        .screens
        .top()
        .filter(|top| top.scope() == Scope::Window);
    let window = top.map_or(Vec::new(), |top| top.hints(model));
    model.screens.open(HelpScreen {
        window,
        ..HelpScreen::default()
    });
}

impl Screen for HelpScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        let action = model.look.keymap.action(key, Scope::Global);
        match key.code {
            Code::Esc => return Some(Step::close()),
            _ if action == Some(Action::Help) && self.typed.is_empty() => {
                return Some(Step::close());
            }
            _ if edit_line(&mut self.typed, key) => self.scroll = 0,
            Code::Up => self.scroll = self.scroll.saturating_sub(1),
            Code::Down => self.scroll += 1,
            Code::PageUp => self.scroll = self.scroll.saturating_sub(PAGE),
            Code::PageDown => self.scroll += PAGE,
            _ => {}
        }
        Some(Step::stay())
    }

    fn paste(&mut self, _model: &mut Model, text: &str) -> Vec<Effect> {
        self.typed.push_str(&first_line(text));
        self.scroll = 0;
        Vec::new()
    }

    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let title = match self.typed.as_str() {
            "" => "keys".to_string(),
            typed => format!("keys · {}▏", fit(typed, 30)),
        };
        let text = text(model, self, window::text_width(screen));
        window::scrolled_in(
            frame,
            screen,
            model,
            &title,
            text,
            window::COLUMNS,
            self.scroll,
        );
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        fixed(&[
            ("type", "to search"),
            ("↑↓", "scroll"),
            ("PgUp PgDn", "a page"),
            ("Esc", "close"),
        ])
    }
}

/// A part of the list: its title, and its keys or signs with what they mean.
type Part = (String, Vec<(String, String)>);

fn text(model: &Model, help: &HelpScreen, columns: usize) -> Text<'static> {
    let theme = &model.theme;
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let key = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let parts = parts(model, help);
    let rows = || parts.iter().flat_map(|(_, rows)| rows);
    let widest = rows().map(|(keys, _)| keys.width()).max().unwrap_or(0);
    let width = widest.clamp(KEYS.0, KEYS.1);
    let mut text = Text::default();
    for (name, rows) in &parts {
        text.push_line(Line::styled(name.clone(), title));
        for (keys, meaning) in rows {
            let mut label = format!("  {} ", pad(keys, width));
            let room = columns.saturating_sub(width + 3).max(10);
            for words in textwrap::wrap(meaning, room) {
                let blank = " ".repeat(label.width());
                text.push_line(Line::from(vec![
                    Span::styled(std::mem::replace(&mut label, blank), key),
                    Span::raw(words.into_owned()),
                ]));
            }
        }
        text.push_line("");
    }
    if parts.is_empty() {
        let nothing = format!("no key or action matches `{}`", fit(&help.typed, 30));
        text.push_line(Line::styled(nothing, Style::new().fg(theme.dim)));
    }
    text
}

/// Matching rows; every typed word must be in a row.
fn parts(model: &Model, help: &HelpScreen) -> Vec<Part> {
    let typed = help.typed.to_lowercase();
    let matches = |row: &str| {
        let row = row.to_lowercase();
        typed.split_whitespace().all(|word| row.contains(word))
    };
    let mut parts: Vec<Part> = Vec::new();
    let mut add = |title: String, entries: &mut dyn Iterator<Item = &Entry>| {
        let mut rows = Vec::new();
        for entry in entries {
            let keys = model
                .look
                .keymap
                .keys(entry)
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join("  ");
            // Actions without keys are shown only when searched: the palette has them.
            let shown = !keys.is_empty() || !typed.is_empty();
            let other = synonyms_of(entry.action);
            if shown && matches(&format!("{keys} {} {} {other}", entry.id, entry.doc)) {
                rows.push((keys, entry.doc.to_string()));
            }
        }
        parts.push((title, rows));
    };
    let here = if help.window.is_empty() {
        here(model)
    } else {
        (Scope::Window, &[][..])
    };
    let of_scope = |scope: Scope| ACTIONS.iter().filter(move |entry| entry.scope == scope);
    let in_pane = |entry: &Entry| entry.scope == Scope::Global && here.1.contains(&entry.action);
    if here.0 != Scope::Global {
        let words = Scope::ALL
            .iter()
            .find(|(scope, ..)| *scope == here.0)
            .map_or("", |(_, _, words)| words);
        let pane = ACTIONS.iter().filter(|entry| in_pane(entry));
        add(format!("here: {words}"), &mut of_scope(here.0).chain(pane));
    }
    // Direct keys first, then the menus.
    for (title, entries) in by_menu(model) {
        let elsewhere = entries.into_iter().filter(|entry| !in_pane(entry));
        add(title, &mut elsewhere.into_iter());
    }
    for (scope, _, words) in Scope::ALL {
        if scope != Scope::Global && scope != here.0 {
            add(words.to_string(), &mut of_scope(scope));
        }
    }
    if let Some((_, rows)) = parts.first_mut().filter(|_| here.0 == Scope::Window) {
        let hints = help.window.iter();
        let matching = hints.filter(|(keys, words)| matches(&format!("{keys} {words}")));
        rows.splice(0..0, matching.cloned());
    }
    let rules = rules().into_iter();
    let rules: Vec<_> = rules
        .filter(|(keys, words)| matches(&format!("{keys} {words}")))
        .collect();
    parts.insert(1.min(parts.len()), ("always".into(), rules));
    let terms = TERMS
        .iter()
        .filter(|(term, words)| matches(&format!("{term} {words}")))
        .map(|(term, words)| ((*term).to_string(), (*words).to_string()));
    parts.push(("in the filter, beside words".into(), terms.collect()));
    let signs = |signs: &[(&str, &str)]| -> Vec<(String, String)> {
        let signs = signs
            .iter()
            .filter(|(sign, words)| matches(&format!("{sign} {words}")));
        signs
            .map(|(sign, words)| ((*sign).to_string(), (*words).to_string()))
            .collect()
    };
    // On the list, what its signs mean is asked before its keys.
    let place = match here.0 {
        Scope::Scenarios => 0,
        _ => parts.len(),
    };
    parts.insert(place, ("signs in the list".into(), signs(&LIST_SIGNS)));
    parts.push(("other signs".into(), signs(&SIGNS)));
    parts.retain(|(_, rows)| !rows.is_empty());
    parts
}

/// The scope of the screen or pane that help was opened on, and the global actions that belong to it.
fn here(model: &Model) -> (Scope, &'static [Action]) {
    let place = model.place();
    let actions = if place.is_own() {
        &[]
    } else {
        model.focus.actions()
    };
    (place, actions)
}

/// The global actions by the menu of their first key, those with a key of their own first.
fn by_menu(model: &Model) -> Vec<(String, Vec<&'static Entry>)> {
    type Menu = (usize, String, Vec<&'static Entry>);
    let mut menus: Vec<Menu> = vec![(0, "everywhere".into(), Vec::new())];
    for entry in ACTIONS.iter().filter(|entry| entry.scope == Scope::Global) {
        let chord = model.look.keymap.keys(entry).next();
        let prefix = chord.map_or(&[][..], |chord| &chord.0[..chord.0.len() - 1]);
        let title = match title_of(prefix) {
            Some(title) => format!("{} · {title}", Chord(prefix.to_vec())),
            None => "everywhere".into(),
        };
        match menus.iter_mut().find(|(_, there, _)| *there == title) {
            Some((.., entries)) => entries.push(entry),
            None => menus.push((1 + order_of(prefix), title, vec![entry])),
        }
    }
    menus.sort_by_key(|(order, ..)| *order);
    let menus = menus.into_iter();
    menus.map(|(_, title, entries)| (title, entries)).collect()
}

/// What some keys do wherever they are pressed.
fn rules() -> Vec<(String, String)> {
    let rows = [
        ("Enter", "does the main thing of the pane"),
        (
            "digits",
            "before a motion repeat it, as in 10j, 5→, 3n; before g g go to that line",
        ),
    ];
    rows.map(|(keys, words)| (keys.to_string(), words.to_string()))
        .into()
}

/// Signs of the list of scenarios.
const LIST_SIGNS: [(&str, &str); 6] = [
    (
        "0X 3",
        "severity of the moment that matters, less is worse: 0 contact, 1 conflict, 2 near miss, 3 course to contact, 4 later course or pass, 5 none of these; X: contact",
    ),
    ("– !", "no ego or no value; the file cannot be read"),
    ("· …", "not read yet; being computed"),
    (
        "= =3",
        "all stored answers agree with the built-in judge; all three of them",
    ),
    (
        "≠ ≠1/3",
        "a stored answer differs from the built-in judge; one of three",
    ),
    ("▸ *", "the selected scenario; marked ones"),
];

const SIGNS: [(&str, &str); 6] = [
    (
        "risk 0–5",
        "risk score of one obstacle at one step, less is worse: 0 collision, 1 extreme, 2 high, 3 medium, 4 low, 5 negligible; the severity in the list is of a whole recording",
    ),
    ("X", "contact: in the list, on the map and on the timeline"),
    ("!", "on the map: risk score 1 or 0"),
    (
        "= ≠",
        "an answer agrees with the built-in judge, or differs from it",
    ),
    (
        "[ ] ▼ ≠ ( )",
        "on the timeline: the window, the moment that matters, an answer that differs, what is looped",
    ),
    (
        "┤ ○",
        "on the timeline: the last moment at which a driver could take over and still avoid the encounter; where the driver that is shown reacts",
    ),
];
