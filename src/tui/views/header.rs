//! The header: the open scenario, and how it would be asked about.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use crate::action::Action;
use crate::loaded::{Opened, VariantShown};
use crate::model::{JobKind, Model, consequence_words};
use crate::widgets::words::{fit, short_techniques, whole_parts};
use nearmiss_drive::generation::Consequence;
use nearmiss_drive::simulation::Outcome;
use nearmiss_scene::judge;
use nearmiss_scene::scenario::EgoSource;
use nearmiss_study::evaluation::with_tools;

pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let asked = asked(model, area.width);
    let room = usize::from(area.width).saturating_sub(asked.width() + PROGRAM);
    let mut line = Line::from(vec![Span::styled(" nearmiss ", bold)]);
    if let Some(opened) = &model.opened {
        // An ego that was chosen changes every number on the screen: it comes before the name.
        let mut room = room;
        if let Some(shown) = &opened.variant {
            let word = fit(which(shown), room);
            room = room.saturating_sub(word.width());
            let style = Style::new().fg(theme.attacker).add_modifier(Modifier::BOLD);
            line.push_span(Span::styled(word, style));
        }
        let own = has_own_ego(model, opened);
        if own {
            let taken = fit(&format!("{} · ", ego(opened, area.width)), room);
            room = room.saturating_sub(taken.width());
            let style = Style::new().fg(theme.ego).add_modifier(Modifier::BOLD);
            line.push_span(Span::styled(taken, style));
        }
        let name = fit(&opened.name, room);
        let rest = room.saturating_sub(name.width());
        let obstacles = match opened.scenario.obstacles.len() {
            1 => "1 obstacle".into(),
            n => format!("{n} obstacles"),
        };
        let recorded = if own {
            String::new()
        } else {
            ego(opened, area.width)
        };
        // What does not fit whole is left out.
        let facts = [name.as_str(), &obstacles, &recorded];
        let facts = whole_parts(facts, room).split_off(name.len());
        line.push_span(Span::styled(
            name,
            theme.base().add_modifier(Modifier::BOLD),
        ));
        let left = rest.saturating_sub(facts.width());
        line.push_span(Span::styled(facts, dim));
        let assumed = match opened.warnings() {
            0 => String::new(),
            1 => format!(" · ! 1 warning ({})", model.look.key(Action::About)),
            n => format!(" · ! {n} warnings ({})", model.look.key(Action::About)),
        };
        if assumed.width() <= left {
            line.push_span(Span::styled(assumed, Style::new().fg(theme.warning)));
        }
    }
    frame.render_widget(line, area);
    let width = u16::try_from(asked.width()).unwrap_or(0).min(area.width);
    let right = Rect {
        x: area.right() - width,
        width,
        ..area
    };
    frame.render_widget(Span::styled(asked, Style::new().fg(theme.title)), right);
}

/// What is at the right, as much of it as there is room for beside the scenario's name: what was spent goes first, then
/// how would be asked, and the price last, as it is on the list of models, too.
fn asked(model: &Model, width: u16) -> String {
    let running = running(model);
    let task = model.task.name();
    let frame = frame_name(model);
    let draft = if model.prompt.is_draft() {
        " · draft"
    } else {
        ""
    };
    let techniques = with_tools(&model.techniques.to_string(), model.tools) + draft;
    let fewer = short_techniques(&techniques);
    let short = match task {
        "collision" => "coll.",
        task => task,
    };
    let (who, priced) = (asked_model(model, width), asked_at_price(model, width));
    let ways = [
        format!("{task} · {frame} · {techniques}"),
        format!("{task} · {frame} · {fewer}"),
        format!("{short} {frame} {fewer}"),
    ];
    let begun = [
        [running.as_slice(), &spent(model)].concat(),
        running.clone(),
    ];
    let [with_sum, without_sum] = begun.map(|parts| {
        let parts = parts.into_iter();
        parts.map(|part| format!("{part} · ")).collect::<String>()
    });
    let mut forms: Vec<String> = Vec::new();
    // Tools multiply the price: they are named beside it where the techniques are not.
    let least = with_tools(task, model.tools) + draft;
    for begun in [&with_sum, &without_sum] {
        forms.extend(ways.iter().map(|way| format!("{begun}{way} · {priced} ")));
        forms.push(format!("{begun}{least} · {priced} "));
    }
    forms.push(format!("{without_sum}{} · {who} ", ways[2]));
    forms.push(format!("{without_sum}{least} · {who} "));
    let opened = model.opened.as_deref();
    let variant = opened.and_then(|opened| opened.variant.as_ref());
    let own = opened.filter(|opened| has_own_ego(model, opened));
    let facts = variant.map_or(0, |shown| which(shown).width())
        + own.map_or(0, |opened| ego(opened, width).width() + SEPARATOR);
    let name = opened.map_or(0, |o| o.name.width());
    // Where nothing fits beside the whole name, it is cut.
    for name in [name, name.min(NAME)] {
        let left = PROGRAM + facts + name;
        let fits = |words: &&String| words.width() + left <= usize::from(width);
        if let Some(words) = forms.iter().find(fits) {
            return words.clone();
        }
    }
    if variant.is_none() {
        return forms.pop().unwrap_or_default();
    }
    if running.is_empty() {
        String::new()
    } else {
        format!("{} ", running.join(" · "))
    }
}

/// Whether the ego was chosen or planned here, not found with the scenario.
fn has_own_ego(model: &Model, opened: &Opened) -> bool {
    model.taken.is_some() || opened.planned.is_some()
}

fn which(shown: &VariantShown) -> &'static str {
    if shown.changed {
        "variant · "
    } else {
        "original · "
    }
}

/// The frame; that of the trajectory task has the same name as the task.
fn frame_name(model: &Model) -> String {
    match model.frame.name() {
        name if name == model.task.name() => format!("{name} frame"),
        name => name.to_string(),
    }
}

/// Columns of the program's name, and between left and right.
const PROGRAM: usize = 12;

/// Columns after a fact.
const SEPARATOR: usize = 3;

/// Columns of its name that a variant keeps beside what it leads to.
const NAME: usize = 24;

/// Columns below which the built-in judge is called so, to leave room for the scenario's name.
const NARROW: u16 = 110;

/// Columns from which on prices are written out.
const WIDE: u16 = 140;

/// The model in short.
fn asked_model(model: &Model, width: u16) -> String {
    let most = if width < NARROW { 24 } else { 40 };
    if model.model != judge::MODEL {
        fit(&model.model, most)
    } else if width < NARROW {
        "built-in".into()
    } else {
        judge::NAME.into()
    }
}

/// The model, and what asking it once costs: nothing is sent before that was on the screen.
fn asked_at_price(model: &Model, width: u16) -> String {
    let name = asked_model(model, width);
    // That the built-in judge is free says its name.
    if model.prompt.question.is_none() || model.model == judge::MODEL {
        return name;
    }
    let price = model.price();
    let bound = price
        .strip_prefix("at most ")
        .map(|usd| format!("≤{usd}/ask"));
    let more = price.strip_suffix(" + answer");
    let short = bound.or_else(|| more.map(|usd| format!("≥{usd}/ask")));
    match short {
        Some(short) if width < WIDE => format!("{name} · {short}"),
        _ => format!("{name} · {}", price.replace("price unknown", "price?")),
    }
}

/// What runs.
fn running(model: &Model) -> Vec<String> {
    let asking = model
        .jobs
        .all
        .iter()
        .filter(|job| job.is_running() && job.asks())
        // How far that one is, is said in another way.
        .filter(|job| !matches!(job.kind, JobKind::Generate));
    let mut parts: Vec<String> = Vec::new();
    match asking.clone().count() {
        0 => {}
        _ => {
            let (done, of) = asking.fold((0, 0), |(done, of), job| (done + job.done, of + job.of));
            parts.push(match of {
                1 => "1 running".into(),
                _ => format!("{} running of {of}", of - done),
            });
        }
    }
    if let Some(drive) = &model.driver.under_way {
        parts.push(match drive.of {
            0 => "planning".into(),
            of => format!("planning {}/{of}", drive.done),
        });
    }
    // How far a search is, the footer says.
    if model.generation.under_way.is_none() && model.jobs.is_stopping(JobKind::Generate) {
        parts.push("cancelling…".into());
    }
    parts
}

/// What the session cost so far; nothing where models were not asked.
fn spent(model: &Model) -> Vec<String> {
    let (usd, unknown) = model.jobs.cost();
    let more = if unknown > 0 { "+" } else { "" };
    let words = (usd > 0.0).then(|| format!("spent ${usd:.4}{more}"));
    words.into_iter().collect()
}

/// The ego in a few words.
fn ego(opened: &Opened, width: u16) -> String {
    match opened.scene.as_ref().map(|s| &s.ego.source) {
        Some(source) if opened.chosen => format!("ego {}", source.short()),
        Some(EgoSource::Recording(_)) => "ego recorded".to_string(),
        Some(EgoSource::Log(_)) => "ego of a log".to_string(),
        Some(EgoSource::Solution { vehicle, .. }) => format!("ego of a solution, {vehicle}"),
        Some(EgoSource::Obstacle(id)) => format!("{id} as ego"),
        Some(EgoSource::Planned { .. }) => match opened.planned.as_ref().map(|p| p.outcome) {
            Some(Outcome::PlannerError(error)) => {
                let until = opened
                    .scene
                    .as_ref()
                    .map_or(0.0, |s| s.time_of(s.last_step()));
                if width >= NARROW {
                    format!("ego planned until {until:.1} s, {error}")
                } else {
                    format!("ego planned until {until:.1} s")
                }
            }
            Some(outcome) if width >= NARROW => {
                format!("ego planned, {}", led_to(opened, &outcome))
            }
            Some(outcome) if opened.variant.is_some() => led_to(opened, &outcome),
            _ => "ego planned".to_string(),
        },
        None => "no ego".to_string(),
    }
}

/// How the ego's drive ended, or in a variant that it was a near one.
fn led_to(opened: &Opened, outcome: &Outcome) -> String {
    let changed = opened.variant.as_ref().filter(|shown| shown.changed);
    match changed.map(|shown| shown.made.effect.consequence) {
        Some(near @ Consequence::NearMiss) => consequence_words(&near).into(),
        _ if matches!(outcome, Outcome::Goal(_)) && opened.seconds() <= 0.0 => {
            "goal reached at the start".into()
        }
        _ => in_short(outcome),
    }
}

/// How a planned drive ended, in two or three words.
fn in_short(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Goal(_) => "goal reached".into(),
        Outcome::Collision(collision) => format!("collision with {}", collision.with),
        Outcome::Timeout => "goal not reached".into(),
        Outcome::OffRoad => "off the road".into(),
        Outcome::Infeasible => "cannot be driven".into(),
        Outcome::PlannerError(error) => error.to_string(),
    }
}
