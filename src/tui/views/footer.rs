//! The footer: the keys that work here and now, the most useful first.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use crate::action::{Action, Entry, Scope};
use crate::keymap::{Chord, Code, Key, KeyMeaning};
use crate::model::{EntryLine, Model, Pane, working_words};
use crate::views::toasts;
use crate::widgets::hints::{Hint, entries, fixed, hint_in, hint_of, pair, together};
use crate::widgets::words::fit;
use nearmiss_scene::description::visible;
use nearmiss_settings::Keys;

pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    // A message at the right leaves the keys their place.
    let message = toasts::message(model, area.width);
    let width = area
        .width
        .saturating_sub(message.map_or(0, |message| message.columns_of_keys()));
    let area = Rect {
        y: area.bottom().saturating_sub(1),
        width,
        height: 1,
        ..area
    };
    let (hints, last) = hints(model, area.width);
    let width = |(keys, words): &Hint| keys.width() + words.width() + 3;
    let reserved: usize = last.iter().map(width).sum();
    let mut left = usize::from(area.width).saturating_sub(reserved);
    let shown = hints.into_iter().take_while(|hint| {
        let fits = left.checked_sub(width(hint));
        left = fits.unwrap_or(0);
        fits.is_some()
    });
    let mut line = Line::default();
    for (keys, words) in shown.chain(last) {
        let key = Style::new()
            .fg(model.theme.accent)
            .add_modifier(Modifier::BOLD);
        line.push_span(Span::styled(format!(" {keys}"), key));
        line.push_span(Span::styled(
            format!(" {words} "),
            Style::new().fg(model.theme.dim),
        ));
    }
    frame.render_widget(line, area);
}

/// The hints, as many as fit, and those that always have their place at the end.
fn hints(model: &Model, width: u16) -> (Vec<Hint>, Vec<Hint>) {
    if let Some(only) = of_mode(model) {
        // The way out and help have their place, however many others there are.
        let out = model.look.key(Action::Cancel);
        let in_editor = model.prompt.editing && model.screens.is_empty();
        let stays = |(key, words): &Hint| words == "help" || (!in_editor && *key == out);
        let (last, hints) = only.into_iter().partition(stays);
        return (hints, last);
    }
    let mut hints: Vec<Hint> = Vec::new();
    if model.answers.is_running() {
        hints.push((model.look.key(Action::Cancel), "cancel request".into()));
    }
    hints.extend(searching(model, width));
    if model.taken.is_some() {
        // The way back is needed only here.
        hints.extend(hint_of(model, Action::RecordedEgo));
    }
    if model.zoomed {
        let key = hint_of(model, Action::Zoom);
        hints.extend(key.map(|(key, _)| (key, "shows all panes".to_string())));
    }
    if model.clock.playing {
        hints.extend(playing(model))
    } else {
        hints.extend(of_pane(model))
    }
    let last: Vec<Hint> = menu(model)
        .into_iter()
        .chain(hint_of(model, Action::Help))
        .collect();
    let rest = entries(Scope::Global)
        .into_iter()
        .filter(|entry| !(model.clock.playing && entry.action == Action::Play))
        .filter_map(|entry| hint_in(model, entry.action, Scope::Global));
    let mut rest = together(rest);
    rest.retain(|hint| !hints.contains(hint) && !last.contains(hint));
    hints.extend(rest);
    (hints, last)
}

/// Columns from which on a search tells all its numbers.
const WIDE: u16 = 140;

/// Columns of why a model that makes the scenario dangerous has not answered yet, at most.
const WAITS: usize = 40;

/// How far the search for an attack is, and the key that cancels it.
fn searching(model: &Model, width: u16) -> Option<Hint> {
    let search = model.generation.under_way.as_ref()?;
    let key = model.look.key(Action::Cancel);
    // The first press only asks.
    let (keys, cancel) = if model.stop_within > 0.0 {
        (key, "again cancels")
    } else {
        (format!("{key} {key}"), "cancel")
    };
    let mut words = format!("{cancel} · {}", working_words(search.at, width >= WIDE));
    if let Some(why) = search.waits.as_ref().filter(|_| width >= WIDE) {
        words.push_str(&format!(" · {}", fit(&visible(why), WAITS)));
    }
    Some((keys, words))
}

/// The hints of a mode that takes all keys.
fn of_mode(model: &Model) -> Option<Vec<Hint>> {
    if let Some(begun) = begun(model) {
        return Some(begun);
    }
    if let Some(screen) = model.screens.top() {
        return Some(screen.hints(model));
    }
    if model.compare.open {
        return Some(comparing(model));
    }
    if model.prompt.editing {
        return Some(editing(model));
    }
    let typed = [
        ("type", "to filter"),
        ("↑↓", "select"),
        ("Enter", "keep"),
        ("Esc", "cancel"),
    ];
    model.list.filtering.is_some().then(|| fixed(&typed))
}

/// A count or a chord that has begun.
fn begun(model: &Model) -> Option<Vec<Hint>> {
    let look = &model.look;
    if look.count.is_none() && look.pending.is_empty() {
        return None;
    }
    let cancel = (look.key(Action::Cancel), "cancel".to_string());
    let count = look.count.map(|count| count.to_string());
    if look.pending.is_empty() {
        return Some(counting(model, count.unwrap_or_default(), cancel));
    }
    let keys = Chord(look.pending.clone()).to_string();
    let begun: Vec<String> = count.into_iter().chain([keys]).collect();
    Some(vec![(begun.join(" "), "…".into()), cancel])
}

/// What a count can stand before.
fn counting(model: &Model, count: String, cancel: Hint) -> Vec<Hint> {
    let scope = model.scope();
    let mut hints = vec![(count, "times:".to_string())];
    let pairs = [
        (scope, [Action::Up, Action::Down], "lines"),
        (
            Scope::Global,
            [Action::StepBack, Action::StepForward],
            "steps",
        ),
        (
            Scope::Global,
            [Action::PreviousObstacle, Action::NextObstacle],
            "obstacles",
        ),
        (
            Scope::Global,
            [Action::PreviousAnswer, Action::NextAnswer],
            "answers",
        ),
    ];
    let there = |&(place, ..): &(Scope, [Action; 2], &str)| place == scope || !scope.is_own();
    let pairs = pairs
        .into_iter()
        .filter(there)
        .map(|(place, actions, words)| pair(model, place, actions, words));
    hints.extend(pairs.filter(|(keys, _)| !keys.is_empty()));
    let top = model.look.keymap.key_in(Action::Top, scope);
    hints.extend((!top.is_empty()).then(|| (top, "line".to_string())));
    hints.push(cancel);
    hints
}

/// The key that leads to everything else.
fn menu(model: &Model) -> Option<Hint> {
    let space = Key::plain(Code::Char(' '));
    let keymap = &model.look.keymap;
    let leads = keymap.meaning(&[space], model.scope()) == KeyMeaning::Prefix;
    leads.then(|| (space.to_string(), "menu".into()))
}

fn playing(model: &Model) -> Vec<Hint> {
    let mut hints = Vec::new();
    if let Some((key, _)) = hint_of(model, Action::Play) {
        hints.push((key, "pause".to_string()));
    }
    let speed = [Action::Slower, Action::Faster];
    hints.push(pair(model, Scope::Global, speed, "speed"));
    hints.extend(hint_of(model, Action::Loop));
    hints
}

/// What the pane that has the keys can do.
fn of_pane(model: &Model) -> Vec<Hint> {
    let scope = model.focus.scope();
    let one = |action, words: &str| {
        let (key, short) = hint_in(model, action, scope)?;
        Some((
            key,
            match words {
                "" => short,
                words => words.into(),
            },
        ))
    };
    let two = |scope, actions, words| {
        let (keys, words) = pair(model, scope, actions, words);
        (!keys.is_empty()).then_some((keys, words))
    };
    use Action::*;
    let answers = two(Scope::Global, [PreviousAnswer, NextAnswer], "answer");
    let claims = two(Scope::Global, [PreviousClaim, NextClaim], "claim");
    let scroll = two(scope, [Up, Down], "scroll");
    let directions = |words: &str| {
        let all = [PanLeft, PanDown, PanUp, PanRight];
        let keys = all.map(|action| model.look.keymap.key_in(action, scope));
        let single = keys.iter().all(|key| key.chars().count() == 1);
        single.then(|| (keys.concat(), words.to_string()))
    };
    let hints = match model.focus {
        Pane::Scenarios => vec![
            one(Choose, ""),
            one(Filter, ""),
            one(MarkScenario, "mark"),
            one(SortScenarios, ""),
            one(AskMarked, "").filter(|_| model.marks.count(&model.list) > 0),
        ],
        Pane::Map | Pane::Timeline if model.map.tape.is_some() => vec![
            one(SwapTape, "other end"),
            directions("move end"),
            one(TakeTape, "close tape"),
        ],
        Pane::Map | Pane::Timeline => vec![
            two(Scope::Global, [ZoomIn, ZoomOut], "zoom"),
            directions("pan"),
            one(NextObstacle, ""),
            one(Follow, ""),
            one(Layers, ""),
            one(FitMap, ""),
        ],
        Pane::Prompt => vec![
            one(PaneMain, "edit"),
            one(PromptView, "view"),
            one(MarkScenario, "mark scenario"),
            scroll,
            one(ToggleFrame, ""),
            one(ChooseTemplate, ""),
        ],
        Pane::Verdict => vec![
            one(PaneMain, enter_on_verdicts(model)),
            answers,
            one(Compare, "ask another"),
            one(CloseAnswer, ""),
        ],
        Pane::Reasoning => vec![
            claims,
            answers,
            scroll,
            one(CompareScreen, ""),
            one(Copy, ""),
        ],
        Pane::Plot => vec![
            one(PaneMain, "measure"),
            one(MinimumStep, ""),
            one(NextObstacle, ""),
            one(Mark, ""),
            one(PlotDrives, ""),
        ],
    };
    hints.into_iter().flatten().collect()
}

/// The keys of the screen of answers side by side.
fn comparing(model: &Model) -> Vec<Hint> {
    let compare = &model.compare;
    if compare.ratings.is_some() {
        return vec![(model.look.key(Action::Cancel), "close".into())];
    }
    if compare.marking.is_some() {
        return fixed(&[
            ("↑↓", "select"),
            ("type", "another reason"),
            ("Enter", "mark"),
            ("Esc", "cancel"),
        ]);
    }
    let (seen, shown) = (model.seen_side_by_side(), compare.shown.len());
    let works = |entry: &Entry| match entry.action {
        Action::BestFirst => shown > 1 && seen.contains(&0),
        Action::BestSecond => shown > 1 && seen.contains(&1),
        Action::RateTie | Action::RateAllWrong => shown > 1,
        Action::MarkWrong | Action::CompareLeft | Action::CompareRight => !compare.shown.is_empty(),
        Action::NextClaim
        | Action::PreviousClaim
        | Action::NextObstacle
        | Action::PreviousObstacle => !compare.hides(),
        Action::NextAnswer | Action::PreviousAnswer => compare.blind.is_none(),
        Action::BestThird => seen.contains(&2),
        Action::BestFourth => seen.contains(&3),
        Action::NextRound => compare.blind.is_some(),
        _ => true,
    };
    let hint = |entry: &Entry| {
        let key = model.look.keymap.keys(entry).next()?;
        Some((key.to_string(), entry.short.to_string()))
    };
    let mut hints: Vec<Hint> = Vec::new();
    if model.answers.is_running() {
        hints.push(("Esc".into(), "cancel request".into()));
    }
    let mut usable: Vec<&Entry> = entries(Scope::Compare)
        .into_iter()
        .filter(|e| works(e))
        .collect();
    if compare.blind.is_none() && shown < model.comparable().len() {
        // What shows the others comes first.
        let fits = shown < model.fit_side_by_side();
        usable.sort_by_key(|entry| match entry.action {
            Action::NextAnswer | Action::PreviousAnswer => 0,
            Action::MoreColumns | Action::FewerColumns if fits => 1,
            _ => 2,
        });
    }
    hints.extend(together(usable.into_iter().filter_map(hint)));
    // Blind, menus would name models.
    hints.extend((!compare.hides()).then(|| ("Space".to_string(), "menu".to_string())));
    hints
}

/// What Enter does in the pane of verdicts.
fn enter_on_verdicts(model: &Model) -> &'static str {
    match model.cursor_obstacle() {
        Some(id) if model.picked == Some(id) => "details",
        Some(_) => "pick",
        None => "side by side",
    }
}

/// The keys of the editor, or of the line below it.
fn editing(model: &Model) -> Vec<Hint> {
    match &model.prompt.entry {
        Some(EntryLine::Find(_)) => {
            return fixed(&[
                ("type", "to find"),
                ("↓ Ctrl-f", "next"),
                ("↑", "previous"),
                ("Enter", "stay there"),
                ("Esc", "go back"),
            ]);
        }
        Some(EntryLine::Line(_) | EntryLine::SaveAs(_) | EntryLine::Command(_)) => {
            let words = match &model.prompt.entry {
                Some(EntryLine::SaveAs(_)) => "save",
                Some(EntryLine::Command(_)) => "run it",
                _ => "go there",
            };
            return fixed(&[("Enter", words), ("Esc", "cancel")]);
        }
        None => {}
    }
    let emacs = model.prompt.editor.keys() == Keys::Emacs;
    let hint = |entry: &&Entry| {
        let mut keys = model.look.keymap.keys(entry);
        // Its own keys are not taken away from Emacs.
        let key = if emacs { keys.last() } else { keys.next() };
        Some((key?.to_string(), entry.short.to_string()))
    };
    let turned = model.prompt.turned && !model.prompt.fits_beside(model.size.0);
    if turned {
        // A view stands in the editor's place.
        let works = [Action::EditDone, Action::Turn, Action::Help];
        let of_editor = entries(Scope::Editor);
        let shown = of_editor
            .iter()
            .filter(|entry| works.contains(&entry.action));
        let mut hints: Vec<Hint> = shown.filter_map(hint).collect();
        if let Some((_, words)) = hints.get_mut(1) {
            *words = "next view".into();
        }
        hints.insert(1.min(hints.len()), ("↑↓".into(), "scroll".into()));
        hints.insert(3.min(hints.len()), ("type".into(), "to edit".into()));
        return hints;
    }
    let mut hints = together(entries(Scope::Editor).iter().filter_map(hint));
    let menu = match model.prompt.editor.keys() {
        Keys::Vim => "Space",
        _ => "F8",
    };
    hints.insert(3.min(hints.len()), (menu.into(), "menu".into()));
    hints
}
