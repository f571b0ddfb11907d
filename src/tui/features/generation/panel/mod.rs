//! The variant: its attack, its outcome and its differences at the cursor, in a panel beside the map.

pub mod authorship;
pub mod certificate;

use std::collections::BTreeMap;

use nearmiss_drive::generation::{
    AttackStyle, AttackerEffect, AttackerRecord, Certificate, CertificateRecord, Consequence,
    GateEvidence, OutcomeName, Reason,
};
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::Motion as State;
use nearmiss_scene::verdict::{Manoeuvre, Motion};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};

use crate::action::Action;
use crate::features::drivers::{self, strip};
use crate::features::generation::panel::certificate::Certified;
use crate::features::{Screen, Step, moves_scene};
use crate::loaded::{GeneratedVariant, SavedVariant, VariantShown};
use crate::model::{Model, consequence_words};
use crate::widgets::hints::{self, Hint};
use crate::widgets::row::{self, Lines};
use crate::widgets::window;
use crate::widgets::words::hundredths;

/// The variant that was made.
#[derive(Debug, Default)]
pub struct VariantScreen {
    scroll: usize,
}

/// Opens the window, where a variant is shown or a model wrote something.
pub fn open(model: &mut Model) {
    if model.variant().is_none() && model.unwritten().is_none() && model.saved().is_none() {
        let why = model.without_variant();
        return model.say(why);
    }
    model.screens.open(VariantScreen::default());
}

impl Screen for VariantScreen {
    fn on_action(&mut self, _model: &mut Model, action: Action) -> Step {
        match action {
            Action::VariantPanel => Step::close(),
            Action::Play
            | Action::PlotDrives
            | Action::SwitchVariant
            | Action::DriverMap
            | Action::NextDriver
            | Action::Drivers
            | Action::SaveVariant
            | Action::Palette => Step::Perform(action),
            _ if moves_scene(action) => Step::Perform(action),
            _ => Step::Ignored,
        }
    }

    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn columns_at_right(&self, screen: Rect) -> Option<u16> {
        Some(row::width(screen))
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let width = row::width(screen);
        let columns = usize::from(width).max(2) - 2;
        let unwritten = model.unwritten().filter(|_| model.variant().is_none());
        let mut text = match (model.variant(), unwritten, model.saved()) {
            (Some(shown), _, _) => text(model, shown, columns),
            (None, Some(wrote), _) => authorship::alone(model, wrote, columns),
            (None, None, Some(saved)) => saved_text(model, saved, columns),
            (None, None, None) => {
                let key = model.look.key(Action::Generate);
                let words = format!("no variant is shown: {key} makes the scenario dangerous");
                Text::styled(words, Style::new().fg(model.theme.dim))
            }
        };
        let title = match unwritten {
            Some(_) => "what the model wrote",
            None => "the variant",
        };
        let left = Rect {
            y: screen.y + 1.min(screen.height),
            width: screen.width - width,
            height: screen.height.saturating_sub(2),
            ..screen
        };
        let mut panel = Rect {
            x: left.right(),
            width,
            ..left
        };
        let strip = model.variant_strip();
        if let Some(strip) = strip.as_ref().filter(|_| strip::fits(left)) {
            strip::draw(frame, left, model, strip);
        } else if let Some(strip) = &strip {
            panel = strip::draw_gaps_above(frame, panel, model, strip);
            let words = format!("a {} terminal shows three maps", strip::least_screen());
            let dim = Style::new().fg(model.theme.dim);
            text.lines.insert(0, Line::styled(words, dim));
        }
        let inner = window::window_at(frame, panel, model, title);
        window::text_in(frame, inner, model, text, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let mut hints = vec![hints::steps(model, "step"), hints::scroll(model)];
        hints.push(hints::close(model));
        let more = [
            Action::SwitchVariant,
            Action::DriverMap,
            Action::NextDriver,
            Action::PlotDrives,
            Action::SaveVariant,
        ];
        hints.extend(
            more.iter()
                .filter_map(|action| hints::hint_of(model, *action)),
        );
        hints
    }
}

fn text(model: &Model, shown: &VariantShown, width: usize) -> Text<'static> {
    let mut lines = Lines::new(&model.theme, width);
    let made = &*shown.made;
    outcome(&mut lines, model, made);
    avoidable(&mut lines, model, made);
    drivers::counted(&mut lines, model);
    gate(&mut lines, made);
    difference(&mut lines, model, made);
    attack(&mut lines, model, shown);
    lines.title("the variant is kept");
    let kept = match model.generation.files(&shown.made) {
        Some(files) => format!("in {}", visible(files)),
        None => {
            let key = model.look.key(Action::SaveVariant);
            format!("until you quit; {key} writes it")
        }
    };
    lines.plain(&kept);
    match &made.authorship {
        Some(wrote) => {
            authorship::written(&mut lines, model, wrote, Some(made.effect.main().obstacle))
        }
        None => refused(&mut lines, made),
    }
    match &made.authorship {
        Some(wrote) => authorship::reasons(&mut lines, wrote),
        None => authorship::ranking(&mut lines, made),
    }
    lines.text
}

fn attack(lines: &mut Lines, model: &Model, shown: &VariantShown) {
    let made = &*shown.made;
    lines.title("the attack");
    let by = match made.authorship {
        Some(_) => format!("written by {}; everything else is computed", made.by),
        None => format!("{}: computed, not recorded", made.by),
    };
    lines.say("source", &visible(&by));
    let dt = made.closed.driver().dt();
    for (asked, attacker) in made.asked.iter().zip(&made.effect.attackers) {
        if made.effect.attackers.len() > 1 {
            lines.say(&attacker.obstacle.to_string(), &nearness_words(attacker));
        }
        let (from, until) = (attacker.from, attacker.until);
        match asked {
            Motion::Manoeuvre(manoeuvre) => {
                lines.say("manoeuvre", &manoeuvre_words(manoeuvre, until as f64 * dt));
            }
            Motion::Waypoints(points) => {
                lines.say("manoeuvre", &format!("follows {} waypoints", points.len()));
            }
        }
        let seconds = from as f64 * dt;
        let words = format!("after step {from} ({seconds:.1} s), up to step {until}");
        lines.say("changed", &words);
    }
    if let Some(only) = made.only {
        lines.say("", &format!("only {only} was allowed to attack"));
    }
    lines.say("others", "as recorded; only the ego reacts");
    let key = model.look.key(Action::SwitchVariant);
    let (now, other) = if shown.changed {
        ("the variant", "original")
    } else {
        ("the original", "variant")
    };
    lines.say("shown", &format!("{now}; {key} the {other}"));
}

/// How near one of several attackers comes, and what the others come to without it.
fn nearness_words(attacker: &AttackerEffect) -> String {
    let mut words = format!(
        "risk {}",
        change(attacker.lowest_before(), attacker.lowest_after())
    );
    if let Some(distance) = attacker.distance {
        words.push_str(&format!(", {} m at least", hundredths(distance)));
    }
    if let Some(without) = &attacker.without {
        words.push_str(&format!("; without it {}", consequence_words(without)));
    }
    words
}

/// Two risk scores, before and after.
fn change(before: Option<u8>, after: Option<u8>) -> String {
    let score = |score: Option<u8>| score.map_or("–".to_string(), |s| s.to_string());
    format!("{} → {}", score(before), score(after))
}

/// A manoeuvre in words; what was asked for may last longer than the attacker moves, `until` so many seconds.
fn manoeuvre_words(m: &Manoeuvre, until: f64) -> String {
    let end = (m.start + m.duration).min(until);
    let mut words = format!("{}, {:.2}–{end:.2} s", m.kind.name(), m.start);
    if let Some(gap) = m.gap {
        words.push_str(&format!(", gap {gap:.2} m"));
    }
    if let Some(speed) = m.speed {
        words.push_str(&format!(", speed {speed:.2} m/s"));
    }
    words
}

fn outcome(lines: &mut Lines, model: &Model, made: &GeneratedVariant) {
    let effect = &made.effect;
    lines.title("outcome, computed");
    let who = |id: i64| {
        let kind = made.closed.scenario().obstacle(id).map(|o| o.kind);
        kind.map_or(id.to_string(), |kind| format!("{kind} {id}"))
    };
    let all: Vec<String> = effect.ids().map(who).collect();
    let name = if all.len() == 1 {
        "attacker"
    } else {
        "attackers"
    };
    lines.say(name, &visible(&all.join(", ")));
    let (words, color) = match effect.consequence {
        Consequence::Collision(c) => (format!("X collision with {c}"), model.theme.danger),
        Consequence::PlannerError(error) => (format!("! {error}"), model.theme.warning),
        Consequence::NearMiss => ("! near miss".to_string(), model.theme.warning),
        other => (consequence_words(&other).to_string(), model.theme.safe),
    };
    let style = Style::new().fg(color).add_modifier(Modifier::BOLD);
    lines.say_in("outcome", &words, style);
    let (before, after) = (effect.lowest_before(), effect.lowest_after());
    let score = change(before, after);
    let anyone = change(effect.anyone_before, effect.anyone_after);
    let others = if anyone == score {
        String::new()
    } else {
        format!(", of all obstacles {anyone}")
    };
    lines.say("risk", &format!("score {score}{others} (0 = collision)"));
    if let Some(distance) = effect.distance() {
        lines.say("smallest distance", &format!("{} m", hundredths(distance)));
    }
    let without = &made.closed.baseline().drive().outcome;
    lines.say("original", &format!("without the attack: {without}"));
}

fn avoidable(lines: &mut Lines, model: &Model, made: &GeneratedVariant) {
    if made.effect.consequence == Consequence::NoEffect {
        return;
    }
    let why = |certificate: &Certificate| match certificate {
        Certificate::Avoided(_) => None,
        Certificate::NotFound(nothing) => Some(nothing.why.to_string()),
    };
    let all = made.avoidability.certificates.iter();
    let certified = Certified {
        delays: all
            .map(|(delay, certificate)| (format!("{delay:.1}"), why(certificate)))
            .collect(),
        driver: made.ideal_driver.as_ref(),
        from: made.effect.from,
        contact: made.effect.contact.map(|contact| contact.step),
        dt: made.closed.driver().dt(),
    };
    certified.add_to(lines, &model.theme);
}

fn refused(lines: &mut Lines, made: &GeneratedVariant) {
    let progress = &made.progress;
    lines.title(&format!(
        "{} motions tried, {} driven against",
        progress.tried, progress.driven
    ));
    let passed = progress.tried.saturating_sub(progress.refused);
    lines.say(&passed.to_string(), "passed the gate");
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for refusal in &made.refused {
        let why = match &refusal.reason {
            Reason::Answer(words) => words,
            reason => reason.name(),
        };
        *reasons.entry(why).or_default() += 1;
    }
    let mut reasons: Vec<(&str, usize)> = reasons.into_iter().collect();
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    for (why, count) in reasons {
        lines.say(&count.to_string(), &format!("refused: {}", visible(why)));
    }
}

fn gate(lines: &mut Lines, made: &GeneratedVariant) {
    lines.title("physically valid: it passed the gate");
    let all = &made.passed;
    let sum = |of: &dyn Fn(&GateEvidence) -> usize| all.iter().map(of).sum::<usize>();
    let (steps, exempt) = (sum(&|p| p.steps), sum(&|p| p.exempt));
    lines.say(
        "steps",
        &format!("{steps} checked, {exempt} exempt as recorded"),
    );
    let friction = all.iter().map(|p| p.friction).fold(0.0, f64::max);
    let friction = format!("at most {:.0} % of the circle used", friction * 100.0);
    lines.say("friction", &friction);
    let limits = match made.style {
        AttackStyle::Human => "emergency limits of a human driver",
        AttackStyle::Limit => "limits of its vehicle",
    };
    lines.say("limits", limits);
    lines.say("place", "stays on the road, overlaps only the ego");
    for (passed, id) in all.iter().zip(made.effect.ids()) {
        if passed.early > 0 {
            let whose = match all.len() {
                1 => String::new(),
                _ => format!("that of {id} "),
            };
            let words = format!("{whose}ends {} steps before the recorded one", passed.early);
            lines.say("motion", &words);
        }
    }
}

/// The two states of each attacker at the cursor.
fn difference(lines: &mut Lines, model: &Model, made: &GeneratedVariant) {
    let step = model.clock.step();
    let time = model.clock.time();
    for attacker in &made.effect.attackers {
        let whose = match made.effect.attackers.len() {
            1 => String::new(),
            _ => format!("{} ", attacker.obstacle),
        };
        let title = format!("{whose}at {time:.1} s, step {step}: recorded → changed");
        lines.title(&title);
        states(lines, made, attacker, step);
    }
}

fn states(lines: &mut Lines, made: &GeneratedVariant, attacker: &AttackerEffect, step: i64) {
    let id = attacker.obstacle;
    let at = |scenario: &nearmiss_scene::scenario::Scenario| -> Option<State> {
        scenario.obstacle(id)?.motion_at(step).cloned()
    };
    let before = at(made.closed.scenario());
    let after = at(&made.effect.scenario);
    let (before, after) = match (before, after) {
        (Some(before), Some(after)) => (before, after),
        (Some(_), None) => return lines.plain("gone by now; still present in the recording"),
        (None, Some(_)) => return lines.plain("absent in the recording at this step"),
        (None, None) => return lines.plain("absent at this step"),
    };
    if step <= attacker.from {
        lines.plain("as recorded until here");
    }
    let (p, q) = (before.pose.position, after.pose.position);
    lines.say(
        "position",
        &format!("{:.2}, {:.2} → {:.2}, {:.2} m", p.x, p.y, q.x, q.y),
    );
    lines.say("apart", &format!("{} m", hundredths((q - p).norm())));
    let both = |a: f64, b: f64, unit: &str| format!("{a:.2} → {b:.2} {unit}");
    let degrees = |state: &State| state.pose.heading.to_degrees();
    lines.say(
        "heading",
        &format!("{:.1}° → {:.1}°", degrees(&before), degrees(&after)),
    );
    lines.say("speed", &both(before.velocity, after.velocity, "m/s"));
    let braking = both(before.acceleration, after.acceleration, "m/s²");
    lines.say("accel.", &braking);
}

/// Attack, outcome and certificates as they were written.
fn saved_text(model: &Model, saved: &SavedVariant, width: usize) -> Text<'static> {
    let mut lines = Lines::new(&model.theme, width);
    let manifest = &saved.origin.manifest;
    lines.title("outcome, from the manifest beside the variant");
    let (color, mark) = match manifest.outcome {
        OutcomeName::Collision => (model.theme.danger, "X "),
        OutcomeName::NoEffect => (model.theme.safe, ""),
        _ => (model.theme.warning, "! "),
    };
    let style = Style::new().fg(color).add_modifier(Modifier::BOLD);
    let outcome = format!("{mark}{}", spoken(manifest.outcome.name()));
    lines.say_in("outcome", &outcome, style);
    if let Some(contact) = &manifest.collision {
        let (with, step) = (contact.with, contact.step);
        let (ego, other) = (visible(&contact.ego_side), visible(&contact.other_side));
        let words = format!("{with} at step {step}: the ego's {ego}, the other's {other}");
        lines.say("contact", &words);
    }
    let ends = spoken(&manifest.drive.ended_with);
    lines.say("ego", &format!("with the attack: {ends}"));
    let without = spoken(&manifest.baseline.ended_with);
    lines.say("original", &format!("without the attack: {without}"));
    certificates(&mut lines, model, saved);
    drivers::counted(&mut lines, model);
    lines.title("the attack");
    for attacker in &manifest.attackers {
        lines.say(&attacker.id.to_string(), &attacker_words(attacker));
    }
    lines.say("source", &visible(&manifest.by));
    lines.say("others", "as recorded; only the ego reacts");
    lines.say(
        "valid",
        "it passed the gate when it was made; `nearmiss generate ORIGINAL --check VARIANT` checks it again",
    );
    let refused = manifest.rejected.len();
    lines.say("refused", &format!("{refused} motions before it"));
    lines.say("made by", &visible(&manifest.program));
    if let Some(opened) = &model.opened {
        lines.say("file", &visible(&opened.file));
    }
    lines.plain("");
    lines.plain(&model.saved_variant(saved));
    lines.text
}

fn certificates(lines: &mut Lines, model: &Model, saved: &SavedVariant) {
    let manifest = &saved.origin.manifest;
    let Some(all) = &manifest.avoidable else {
        return;
    };
    let why = |record: &CertificateRecord| {
        (!record.avoided).then(|| record.why.clone().unwrap_or_default())
    };
    let avoided = all.values().rev().filter(|record| record.avoided);
    let certified = Certified {
        delays: all
            .iter()
            .map(|(delay, record)| (visible(delay).into_owned(), why(record)))
            .collect(),
        driver: avoided.filter_map(|record| record.evasion.as_ref()).next(),
        from: saved.origin.from(),
        contact: manifest.collision.as_ref().map(|contact| contact.step),
        dt: manifest.change.seconds_per_step,
    };
    certified.add_to(lines, &model.theme);
}

fn attacker_words(attacker: &AttackerRecord) -> String {
    let risk = change(attacker.min_risk_before, attacker.min_risk_after);
    let mut words = format!("{}, risk {risk}", visible(&attacker.manoeuvre));
    if let Some(distance) = attacker.min_distance {
        words.push_str(&format!(", {} m at least", hundredths(distance)));
    }
    if let Some(without) = &attacker.outcome_without {
        words.push_str(&format!("; without it {}", spoken(without)));
    }
    words
}

/// A name of a document as words.
fn spoken(name: &str) -> String {
    visible(name).replace('_', " ")
}
