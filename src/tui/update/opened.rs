//! A scenario has been opened: what is kept and dropped of the previous one, by a jump, for an earlier run.

use crate::action::Action;
use crate::clock::Clock;
use crate::features::experiment::ExperimentScreen;
use crate::features::history::{self, HistoryScreen};
use crate::features::{answers, generation, planner, timeline};
use crate::loaded::{Opened, StandInEgo};
use crate::message::Effect;
use crate::model::{Column, Model, NEIGHBOURHOOD, Notice, OpenId, ShownAnswer, Values};
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::session::restore;
use crate::update::opening::{Open, arrive, open, open_changed};
use nearmiss_ask::prompts::Techniques;
use nearmiss_base::geometry::Bounds;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::description::Frame;
use nearmiss_scene::scenario::{Transform, obstacle_taken};
use nearmiss_scene::verdict::Verdict;
use nearmiss_store::Run;
use nearmiss_study::evaluation::claims::{self, Subject};
use nearmiss_study::evaluation::{Answer, JudgeOutcome};

impl Request for Open {
    /// The scenario, or why it is not open.
    type Reply = (OpenId, Result<Box<Opened>, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let ego = match self.obstacle {
            Some(obstacle) => EgoSelection::Obstacle(obstacle),
            None => services.ego.clone(),
        };
        let thresholds = services.thresholds.clone();
        services.background(replies, move || {
            let opened = Opened::changed(&self.entry, &ego, &thresholds, self.change);
            (self.id, opened.map(Box::new))
        });
    }

    fn reply(model: &mut Model, (id, result): Self::Reply) -> Vec<Effect> {
        model.recall.changed = true;
        opened(model, id, result)
    }
}

pub fn opened(model: &mut Model, id: OpenId, result: Result<Box<Opened>, String>) -> Vec<Effect> {
    let Some((_, ego)) = model.opening.filter(|(opening, _)| *opening == id) else {
        return Vec::new();
    };
    model.opening = None;
    timeline::opened(model, id);
    let opened = match result {
        Ok(opened) => planner::with_kept_drive(model, id, ego, opened),
        Err(_) if restore::is_wanted(model) && ego.is_some() => {
            // The obstacle that was the ego is no longer in the file.
            let place = model.list.opened;
            return place.map_or_else(Vec::new, |place| open(model, place, None));
        }
        Err(message) if ego.is_some() && model.opened.is_some() => {
            // The open scenario stays open.
            model.complain(message);
            return Vec::new();
        }
        Err(message) => {
            leave(model);
            model.generation.wanted = None;
            model.opened = None;
            model.open_error = Some(message);
            model.refresh();
            return Vec::new();
        }
    };
    let again = model
        .opened
        .as_ref()
        .filter(|o| o.scenario.hash == opened.scenario.hash);
    let step = again.map(|_| model.clock.step());
    let kept = again.map(|before| PreservedView::new(model, before, &opened));
    leave(model);
    model.open_error = None;
    if kept.is_none() {
        model.toasts.retain(|t| t.kind != Notice::Reply);
    }
    let clock = Clock::new(opened.steps(), opened.scenario.dt());
    model.clock = clock.like(&model.clock);
    match step {
        Some(step) => model.clock.go(step),
        None => model.map.second.pinned = None,
    }
    let same_ego = kept.as_ref().is_some_and(|kept| kept.same_ego);
    if !same_ego {
        frame_map(model, &opened);
    }
    let worst = opened.headline.as_ref().and_then(|h| h.worst());
    model.picked = worst.map(|moment| moment.obstacle);
    if let Some(kept) = kept {
        if kept.same_ego {
            model.picked = kept.picked;
        }
        let ego = opened.scene.as_ref().map(|s| s.ego.id);
        model.plot.marked = kept.marked;
        model.plot.marked.retain(|&id| Some(id) != ego);
    }
    model.taken = ego;
    if let (Some(id), false) = (ego, same_ego) {
        let back = model.look.key(Action::RecordedEgo);
        model.say(format!("{id} is the ego now; {back} goes back"));
    }
    // The list agrees with the obstacle that is the ego without being asked to; drives it learns of the planner.
    let own_ego = opened.planned.is_none() && opened.variant.is_none() && opened.change.is_none();
    if let Some(place) = model.list.opened.filter(|_| own_ego && ego.is_none()) {
        let stands_in = StandInEgo::of(&opened);
        if stands_in.is_some() {
            model.list.stand_in(place, stands_in);
        }
    }
    model.opened = Some(opened);
    if step.is_none() {
        timeline::to_moment(model);
    }
    model.refresh();
    reopened(model, id);
    jumped(model, id);
    restore::opened(model);
    let mut effects: Vec<Effect> = answers::load(model).into_iter().collect();
    effects.extend(generation::opened(model));
    effects
}

/// State kept when the open scenario is opened again.
struct PreservedView {
    /// Whether its ego is the same too, as when thresholds are read again.
    same_ego: bool,
    picked: Option<i64>,
    marked: Vec<i64>,
}

impl PreservedView {
    fn new(model: &Model, before: &Opened, now: &Opened) -> Self {
        let ego = |opened: &Opened| opened.scene.as_ref().map(|s| s.ego.to_string());
        Self {
            same_ego: ego(before) == ego(now),
            picked: model.picked,
            marked: model.plot.marked.clone(),
        }
    }
}

/// Puts away what belongs to the scenario that was open.
fn leave(model: &mut Model) {
    let name = model
        .opened
        .as_ref()
        .map_or(String::new(), |o| o.name.clone());
    answers::leave(model, &name);
    model.answers.reference_ms = None;
    model.answers.show(ShownAnswer::Reference);
    model.taken = None;
    model.picked = None;
    model.plot.marked.clear();
    model.map.tape = None;
    model.values = Values::default();
    model.prompt.scroll = 0;
}

/// Points the map at the ego, or at everything where there is none.
fn frame_map(model: &mut Model, opened: &Opened) {
    if opened.scene.is_some() {
        model.camera.follow = true;
        model.camera.fitted = None;
        model.camera.shift = nearmiss_base::geometry::Vector::zeros();
        let (columns, _) = model.drawn.map_size();
        model.camera.show_at_least(NEIGHBOURHOOD, columns);
        return;
    }
    let positions: Vec<_> = opened
        .scenario
        .obstacles
        .iter()
        .flat_map(|o| o.track().iter().map(|(_, m)| m.pose.position))
        .collect();
    let bounds = Bounds::from_points(&positions).or_else(|| opened.scenario.network.bounds());
    if let Some(bounds) = bounds {
        let size = model.drawn.map_size();
        model.camera.fit(&bounds, None, size);
    }
}

/// A scenario was opened: where it is that of a place to go to, the clock and the picked obstacle follow.
pub fn jumped(model: &mut Model, id: OpenId) {
    let Some((opening, place)) = model.jumps.arriving.take() else {
        return;
    };
    if opening == id {
        arrive(model, &place);
    }
}

/// Opens the scenario of a run, if it is to be found.
pub fn begin(model: &mut Model, run: Run) -> Vec<Effect> {
    let name = run.question.scenario.clone();
    let Some(entry) = model.files_of(&name).into_iter().next() else {
        model.say(format!(
            "{name} is not in the list; start nearmiss with the folder that it is in"
        ));
        return Vec::new();
    };
    model.screens.close::<HistoryScreen>();
    model.screens.close::<ExperimentScreen>();
    let mut effects = history::leave(model);
    let listed = model.list.rows.iter().position(|row| row.entry == entry);
    let place = listed.unwrap_or_else(|| model.list.append(entry));
    model.list.show(place);
    model.zoomed = false;
    let (ego, (_, change)) = (obstacle_taken(&run.question.ego), Transform::of_name(&name));
    effects.extend(open_changed(model, place, ego, change));
    if let Some((id, _)) = model.opening {
        model.reopening = Some((id, Box::new(run)));
    }
    effects
}

/// A scenario was opened: if it was for a run, it is asked about as the run was, and the answer stands beside it.
pub fn reopened(model: &mut Model, id: OpenId) {
    let Some((_, run)) = model.reopening.take_if(|(opening, _)| *opening == id) else {
        return;
    };
    let question = &run.question;
    // Answers to another question do not compare.
    if model.task != question.task {
        answers::leave(model, &question.scenario);
        model.task = question.task;
    }
    if let Some(frame) = Frame::parse(&question.frame) {
        model.frame = frame;
        model.frame_chosen = Some(frame);
    }
    if let Ok(techniques) = Techniques::parse(&question.techniques) {
        model.techniques = techniques;
        model.techniques_chosen = true;
    }
    if let Some((_, last)) = question.window {
        model.clock.playing = false;
        model.clock.go(last);
        model.placed = None;
    }
    model.refresh();
    let hash = model.opened.as_ref().map(|o| o.scenario.hash.to_string());
    let ego = model.scene().map(|scene| scene.ego.to_string());
    let mut doubts = Vec::new();
    if question.scenario_hash.is_some() && question.scenario_hash != hash {
        doubts.push("the file has changed since");
    }
    if question.scenario_hash.is_some() && ego.as_ref() != Some(&question.ego) {
        doubts.push("its ego has changed since");
    }
    let doubts: String = doubts.iter().map(|d| format!("; {d}")).collect();
    let changed = match model.opened.as_ref().and_then(|opened| opened.change) {
        Some(change) => {
            let back = model.look.key(Action::RecordedEgo);
            format!(", transformed as for the answer: {change}; {back} shows the original")
        }
        None => String::new(),
    };
    let text = format!("run {} reopened{changed}{doubts}", run.id);
    if doubts.is_empty() {
        model.say(text);
    } else {
        model.complain(text);
    }
    model.reopened = Some(run.id);
    let answer = Answer::from(*run);
    let foremost = foremost(model, &answer);
    if foremost.is_some() {
        model.picked = foremost;
        model.refresh();
    }
    put(model, answer);
}

/// The obstacle that an answer calls most dangerous, else the first that it says something of.
fn foremost(model: &Model, answer: &Answer) -> Option<i64> {
    let scene = model.scene()?;
    let subject = Subject::new(scene, answer.times, answer.window);
    let worst = answer.verdict().and_then(Verdict::foremost);
    let other = match &answer.judged {
        JudgeOutcome::Other(reading) => reading.said.named(),
        _ => Vec::new(),
    };
    let said = claims::find(&answer.text, &subject).into_iter();
    { worst.into_iter().map(|(id, _)| id) }
        .chain(other)
        .chain(said.map(|claim| claim.obstacle))
        .find(|id| *id != scene.ego.id && scene.scenario.obstacle(*id).is_some())
}

/// Earlier answers came, and the one that was opened again was not to hide them: it takes its place among them.
pub fn before_stored(model: &mut Model) -> Option<Column> {
    let run = model.reopened.take()?;
    let only = model.answers.columns.len() == 1;
    let is_it = |column: &Column| column.answer().and_then(|a| a.run) == Some(run);
    if !only || !is_it(&model.answers.columns[0]) {
        return None;
    }
    model.answers.columns.pop()
}

/// Puts it back.
pub fn after_stored(model: &mut Model, column: Column) {
    if let Some(answer) = column.answer() {
        put(model, answer.clone());
    }
}

/// Shows an answer of the store; the same run stands there once.
fn put(model: &mut Model, answer: Answer) {
    let run = answer.run;
    let same = |c: &Column| c.answer().and_then(|a| a.run) == run;
    model.answers.columns.retain(|column| !same(column));
    model.answers.add(Column::from(answer));
    let last = model.answers.columns.len() - 1;
    model.answers.show(ShownAnswer::Column(last));
}
