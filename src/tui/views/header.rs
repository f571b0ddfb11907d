//! The header: the open scenario, and how it would be asked about.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use crate::description::visible;
use crate::generation::Consequence;
use crate::judge;
use crate::scenario::EgoSource;
use crate::simulation::Outcome;
use crate::tui::action::Action;
use crate::tui::loaded::{Opened, VariantShown};
use crate::tui::model::{JobKind, Model, consequence_words, working_words};
use crate::tui::widgets::words::fit;

pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let (running, who) = (running(model, area.width), asked_model(model, area.width));
    let asked = asked(model, area.width, &running, &who);
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
        let own = model.taken.is_some() || opened.planned.is_some();
        if own {
            let taken = fit(&format!("{} · ", ego(opened, area.width)), room);
            room = room.saturating_sub(taken.width());
            let style = Style::new().fg(theme.ego).add_modifier(Modifier::BOLD);
            line.push_span(Span::styled(taken, style));
        }
        let name = fit(&opened.name, room);
        let rest = room.saturating_sub(name.width());
        let mut facts = format!(" · {} obstacles", opened.scenario.obstacles.len());
        if !own {
            facts.push_str(&format!(" · {}", ego(opened, area.width)));
        }
        line.push_span(Span::styled(
            name,
            theme.base().add_modifier(Modifier::BOLD),
        ));
        let shown = fit(&facts, rest);
        let left = rest.saturating_sub(shown.width());
        line.push_span(Span::styled(shown, dim));
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

/// What is at the right, as much of it as there is room for: what runs matters more than how would be asked, and the
/// scenario's name more than both; so does what a variant leads to.
fn asked(model: &Model, width: u16, running: &str, who: &str) -> String {
    let task = model.task.name();
    let whole = format!(
        "{running}{task} · {} · {} · {who} ",
        frame_name(model),
        model.techniques
    );
    let short = format!("{running}{task} · {who} ");
    let fits = |words: &str, left: usize| words.width() + left <= usize::from(width);
    let opened = model.opened.as_deref();
    let variant = opened.and_then(|opened| Some((opened, opened.variant.as_ref()?)));
    let left = match variant {
        Some((opened, shown)) => {
            let facts = which(shown).width() + ego(opened, width).width() + SEPARATOR;
            PROGRAM + facts + opened.name.width().min(NAME)
        }
        None if running.is_empty() => 0,
        None => LEAST,
    };
    if fits(&whole, left) {
        return whole;
    }
    if fits(&short, left) || (variant.is_none() && model.maker.under_way.is_none()) {
        return short;
    }
    match running.strip_suffix(" · ") {
        Some(running) => format!("{running} "),
        None => String::new(),
    }
}

fn which(shown: &VariantShown) -> &'static str {
    match shown.changed {
        true => "variant · ",
        false => "original · ",
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

/// Columns that are left to the program's and the scenario's name.
const LEAST: usize = 36;

/// Columns below which the built-in judge is called so, to leave room for the scenario's name.
const NARROW: u16 = 110;

/// Columns from which on a search tells all its numbers.
const WIDE: u16 = 140;

/// Columns of why a model that makes the scenario dangerous has not answered yet, at most.
const WAITS: usize = 40;

/// The model, and what asking it once costs: nothing is sent before that was on the screen.
fn asked_model(model: &Model, width: u16) -> String {
    let most = if width < NARROW { 24 } else { 40 };
    let name = match width < NARROW && model.model == judge::MODEL {
        true => "built-in".into(),
        false => fit(&model.model, most),
    };
    // That the built-in judge is free says its name.
    if model.prompt.question.is_none() || (width < NARROW && model.model == judge::MODEL) {
        return name;
    }
    let price = match model.price() {
        price if width >= WIDE => price,
        price => price
            .replace("at most ", "≤")
            .replace("price unknown", "price?"),
    };
    format!("{name} · {price}")
}

/// What runs, and what the session cost so far; nothing where models were not asked.
fn running(model: &Model, width: u16) -> String {
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
    if let Some(search) = &model.maker.under_way {
        parts.push(working_words(search.at, width >= WIDE));
        if let Some(why) = search.waits.as_ref().filter(|_| width >= WIDE) {
            parts.push(fit(&visible(why), WAITS));
        }
    } else if model.jobs.is_stopping(JobKind::Generate) {
        parts.push("cancelling…".into());
    }
    let (usd, unknown) = model.jobs.cost();
    if usd > 0.0 {
        let more = if unknown > 0 { "+" } else { "" };
        parts.push(format!("${usd:.4}{more}"));
    }
    match parts.is_empty() {
        true => String::new(),
        false => format!("{} · ", parts.join(" · ")),
    }
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
    }
}
