//! Runs the planner for the ego, shows its drives again, and its cycles.

pub mod cycle;
pub mod request;
pub mod state;

use std::time::Duration;

use crate::action::Action;
use crate::features::generation;
use crate::loaded::{DriveFiles, DriveKey, Opened, StandInEgo};
use crate::message::Effect;
use crate::model::{
    Camera, Drives, Job, JobId, JobState, Model, NEIGHBOURHOOD, OpenId, RunningDrive, Update,
    forecast_words,
};
use nearmiss_drive::planner::{Forecast, occupancy_sets};
use nearmiss_workflow::MissingEgo;
use request::{Plan, PlanUpdate, SaveDrive};

/// Seconds a scenario without an ego stays open before one is planned for it, so that moving through the list does not
/// plan one for each.
const AUTO_PLAN_DELAY: f64 = 0.6;

/// Metres of a column at most, so that what was chosen is on the map: beyond, bodies are too small.
const COARSEST: f64 = 1.2;

/// Does what an action about the planner says.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    match action {
        Action::DrivePlanner => return drive(model),
        Action::NextForecast => return next_forecast(model),
        Action::NextPlanner => return next_planner(model),
        Action::SaveDrive => return save(model),
        Action::PlotDrives => plot_drives(model),
        _ => return generation::perform(model, action),
    }
    Vec::new()
}

/// Lets the planner drive, or stops it.
fn drive(model: &mut Model) -> Vec<Effect> {
    if model.driver.under_way.is_some() {
        let key = model.look.key(Action::DrivePlanner);
        model.say(format!("planning is cancelled; {key} plans again"));
        return cancel(model);
    }
    let planned = model
        .planned()
        .map(|planned| (planned.forecast, planned.planner));
    if planned == Some((model.driver.forecast, model.driver.planner)) {
        let key = model.look.key(Action::NextForecast);
        model.say(format!(
            "the drive is the same each time; {key} changes the prediction"
        ));
        return Vec::new();
    }
    show(model).unwrap_or_else(|| begin(model))
}

/// Where a planned ego is shown or on its way, it drives anew.
fn driven_anew(model: &mut Model) -> Option<Vec<Effect>> {
    (model.planned().is_some() || model.driver.under_way.is_some()).then(|| {
        let mut effects = stop(model);
        effects.extend(show(model).unwrap_or_else(|| begin(model)));
        effects
    })
}

/// Tells the planner something else; where a planned ego is shown or on its way, it drives anew.
fn next_forecast(model: &mut Model) -> Vec<Effect> {
    if let Some(why) = model.nothing_to_plan() {
        model.say(why);
        return Vec::new();
    }
    if model.variant().is_some() {
        model.say(generation::fixed(model));
        return Vec::new();
    }
    model.driver.forecast = match model.driver.forecast {
        Forecast::Lane => Forecast::ConstantVelocity,
        Forecast::ConstantVelocity => Forecast::Recorded,
        Forecast::Recorded => Forecast::Lane,
    };
    let words = forecast_words(model.driver.forecast);
    if let Some(effects) = driven_anew(model) {
        return effects;
    }
    let key = model.look.key(Action::DrivePlanner);
    model.say(format!("{key} drives with {words}"));
    Vec::new()
}

/// Lets another planner drive; where a planned ego is shown or on its way, it drives anew.
fn next_planner(model: &mut Model) -> Vec<Effect> {
    if model.driver.planners.is_empty() {
        model.say("only the built-in planner: [planner.NAME] in config.toml adds others");
        return Vec::new();
    }
    if model.variant().is_some() {
        model.say(generation::fixed(model));
        return Vec::new();
    }
    model.driver.planner = (model.driver.planner + 1) % (model.driver.planners.len() + 1);
    if let Some(effects) = driven_anew(model) {
        return effects;
    }
    let key = model.look.key(Action::DrivePlanner);
    let name = model.driver.planner_name();
    model.say(format!("{key} lets {name} drive"));
    Vec::new()
}

fn begin(model: &mut Model) -> Vec<Effect> {
    match (&model.opened, model.list.opened) {
        // Replies go when the scenario is open.
        _ if model.opening.is_some() => {
            model.tell("the scenario was still being read; press the key again");
        }
        (None, _) | (_, None) => model.say("no scenario is open"),
        (Some(_), Some(place)) => {
            if let Some(why) = model.nothing_to_plan() {
                model.say(why);
                return Vec::new();
            }
            let words = forecast_words(model.driver.forecast);
            let key = model.look.key(Action::DrivePlanner);
            let planner = match model.driver.planner {
                0 => "the planner",
                _ => model.driver.planner_name(),
            };
            model.say(format!("{planner} drives with {words}; {key} stops it"));
            return again(model, place);
        }
    }
    Vec::new()
}

/// Plans the ego of what is open.
pub fn again(model: &mut Model, place: usize) -> Vec<Effect> {
    let mut effects = stop(model);
    let change = model.opened.as_deref().and_then(|opened| opened.change);
    let id = JobId(model.new_id());
    model.driver.waits = None;
    model.driver.under_way = Some(RunningDrive {
        id,
        place,
        done: 0,
        of: 0,
    });
    let plan = Plan {
        id,
        entry: model.list.rows[place].entry.clone(),
        change,
        forecast: model.driver.forecast,
        planner: model.driver.planner,
    };
    effects.push(plan.into());
    effects
}

/// Cancels the drive in progress, which is not restarted automatically.
pub fn cancel(model: &mut Model) -> Vec<Effect> {
    decline(model);
    stop(model)
}

/// Stops what is under way.
fn stop(model: &mut Model) -> Vec<Effect> {
    let under_way = model.driver.under_way.take();
    let stop = |drive: RunningDrive| Effect::Cancel(drive.id);
    under_way.map(stop).into_iter().collect()
}

/// A planned ego gives its place back.
pub fn take_back(model: &mut Model) {
    if model.variant().is_some() {
        return generation::left(model);
    }
    let recorded = model.planned().map(|planned| planned.recorded.is_some());
    match recorded {
        Some(true) => model.say("the recorded ego again"),
        Some(false) => model.say("no ego: none was recorded"),
        None => {}
    }
    if let Some(opened) = &model.opened {
        let (hash, change) = (opened.scenario.hash, opened.change);
        model.driver.kept.put_away(hash, change);
    }
    decline(model);
}

/// The scenario that is open shall not get a planned ego by itself.
fn decline(model: &mut Model) {
    model.driver.declined = model.opened.as_ref().map(|o| o.scenario.hash);
    model.driver.waits = None;
}

/// What is planned belongs to what is open: where something else is opened, planning stops. A scenario without an ego
/// that stays open gets one.
pub fn request(model: &mut Model) -> Vec<Effect> {
    announce_kept_drive(model);
    let leaves = |drive: &RunningDrive| {
        model.opening.is_some() || model.opened.is_none() || model.list.opened != Some(drive.place)
    };
    let effects = if model.driver.under_way.as_ref().is_some_and(leaves) {
        stop(model)
    } else {
        Vec::new()
    };
    let open = model.opened.as_ref().map(|o| o.scenario.hash);
    if model.opening.is_none() && model.driver.declined != open {
        model.driver.declined = None;
    }
    let lacking = model.list.opened.filter(|_| lacks_ego(model));
    let same = |waits: &(usize, f64)| Some(waits.0) == lacking;
    let waits = model.driver.waits.filter(same);
    model.driver.waits = waits.or(lacking.map(|place| (place, AUTO_PLAN_DELAY)));
    effects
}

/// Whether an ego is to be planned because there is none.
fn lacks_ego(model: &Model) -> bool {
    let Some(opened) = &model.opened else {
        return false;
    };
    let none = opened.scene.is_none() && opened.no_ego == Some(MissingEgo::NotRecorded);
    let busy = model.opening.is_some() || model.driver.under_way.is_some();
    let declined = model.driver.declined == Some(opened.scenario.hash);
    none && !busy && !declined && !opened.scenario.planning_problems.is_empty()
}

/// Time passes: a scenario that has stayed open long enough gets its ego.
pub fn pass(model: &mut Model, seconds: f64) -> Vec<Effect> {
    match &mut model.driver.waits {
        Some((place, left)) => {
            *left -= seconds;
            let (place, left) = (*place, *left);
            if left > 0.0 {
                return Vec::new();
            }
            show(model).unwrap_or_else(|| again(model, place))
        }
        None => Vec::new(),
    }
}

/// How far the drive is that is under way, or what came of it.
pub fn on_update(model: &mut Model, update: PlanUpdate) -> Vec<Effect> {
    match update {
        Update::Progress((done, of)) => {
            if let Some(drive) = &mut model.driver.under_way {
                (drive.done, drive.of) = (done.min(of), of);
            }
            Vec::new()
        }
        Update::Ended(Ok(opened)) => {
            model.driver.under_way = None;
            model.driver.declined = None;
            model.driver.kept.keep(&opened);
            take(model, opened)
        }
        Update::Ended(Err(why)) => {
            model.driver.under_way = None;
            decline(model);
            model.complain(format!("no ego was planned: {why}"));
            Vec::new()
        }
        Update::Cancelled => Vec::new(),
    }
}

/// The planned ego is the ego from now on.
fn take(model: &mut Model, opened: Box<Opened>) -> Vec<Effect> {
    let back = model.look.key(Action::RecordedEgo);
    let words = opened.planned.as_ref().map(|planned| {
        let way = match planned.recorded {
            Some(_) => format!("{back} goes back to the recorded ego"),
            None => "no ego was recorded".to_string(),
        };
        let sets = occupancy_sets(&opened.scenario);
        let but = sets.map_or(String::new(), |words| format!("; {words}"));
        format!("ego planned: {}; {way}{but}", planned.ended())
    });
    let without = model.opened.as_ref().is_some_and(|o| o.scene.is_none());
    let recorded = opened
        .planned
        .as_ref()
        .is_some_and(|planned| planned.recorded.is_some());
    if let Some(place) = model
        .list
        .opened
        .filter(|_| !recorded && opened.change.is_none())
    {
        model.list.stand_in(place, StandInEgo::of(&opened));
    }
    let id = OpenId(model.new_id());
    model.opening = Some((id, None));
    let reach = opened
        .planned
        .as_ref()
        .map_or(0.0, |planned| planned.reach());
    let effects = crate::update::opened(model, id, Ok(opened));
    if without {
        // The map showed all participants, from far away.
        model.camera.cell = Camera::default().cell;
    }
    show_reach(model, reach);
    if without {
        // The window had no ego until now.
        super::timeline::to_moment(model);
        model.refresh();
    }
    if let Some(words) = words {
        // It goes with the next key: another scenario has another ego.
        model.say(words);
    }
    effects
}

/// Shows what was chosen on the map, as far as bodies stay large enough to be seen.
fn show_reach(model: &mut Model, reach: f64) {
    let (columns, _) = model.drawn.map_size();
    let most = COARSEST * f64::from(columns);
    let shown = reach.min(most).max(NEIGHBOURHOOD);
    model.camera.show_at_least(shown, columns);
}

/// Notes in the list of tasks how far it is.
pub fn note(job: &mut Job, update: &PlanUpdate, now: Duration) {
    match update {
        Update::Progress((done, of)) => (job.done, job.of) = (*done.min(of), *of),
        Update::Ended(Ok(opened)) => {
            let planned = opened.planned.as_ref();
            let words = planned.map_or(String::new(), |p| p.outcome.to_string());
            job.end(JobState::Done(words), now);
        }
        Update::Ended(Err(why)) => job.end(JobState::Failed(why.clone()), now),
        Update::Cancelled => job.end(JobState::Cancelled(String::new()), now),
    }
}

/// Plots the next thing about both egos, or the measure again.
fn plot_drives(model: &mut Model) {
    let Some(planned) = model.planned() else {
        let why = model.unplanned();
        return model.say(why);
    };
    let (both, varied) = (planned.recorded.is_some(), model.variant().is_some());
    model.plot.drives = match model.plot.drives {
        None if varied => Some(Drives::Risk),
        None | Some(Drives::Risk) => Some(Drives::Speed),
        Some(Drives::Speed) if both => Some(Drives::Distance),
        Some(_) => None,
    };
    let words = match model.plot.drives {
        Some(Drives::Speed) if both => "speeds of the planned and the recorded ego",
        Some(Drives::Speed) => "speed of the planned ego",
        Some(Drives::Risk) => "risk scores of the attacker, before and after",
        Some(Drives::Distance) => "distance between the planned and the recorded ego",
        None => "the measure again",
    };
    model.say(words);
}

/// The drive that the planner would make now, if it was made before.
fn kept(model: &Model) -> Option<Box<Opened>> {
    let opened = model
        .opened
        .as_deref()
        .filter(|_| model.opening.is_none())?;
    let key = DriveKey {
        hash: opened.scenario.hash,
        change: opened.change,
        forecast: model.driver.forecast,
        planner: model.driver.planner,
    };
    let drive = model.driver.kept.find(key)?;
    Some(drive.opened.clone())
}

/// Shows the drive that the planner would make now, if it was made before.
fn show(model: &mut Model) -> Option<Vec<Effect>> {
    let opened = kept(model)?;
    model.driver.waits = None;
    model.driver.declined = None;
    if let Some(key) = opened.drive_key() {
        model.driver.kept.show(key);
    }
    Some(take(model, opened))
}

/// What was opened; or, where its planned ego was shown when it was left, that one. What is opened for an earlier run
/// has that run's ego, and an obstacle that was asked for is the ego.
pub fn with_kept_drive(
    model: &mut Model,
    id: OpenId,
    ego: Option<i64>,
    opened: Box<Opened>,
) -> Box<Opened> {
    if opened.planned.is_some() {
        return opened;
    }
    let (hash, change) = (opened.scenario.hash, opened.change);
    if ego.is_some() {
        model.driver.kept.put_away(hash, change);
        return opened;
    }
    let run = model
        .reopening
        .as_ref()
        .and_then(|(of, run)| (*of == id).then_some(&run.question.ego));
    let of_run = run.is_some();
    let drive = model
        .driver
        .kept
        .for_scenario(hash, change)
        .find(|drive| match run {
            Some(ego) => {
                drive.opened.scene.as_ref().map(|s| s.ego.to_string()) == Some(ego.clone())
            }
            None => drive.shown,
        });
    let found = drive.map(|drive| (drive.key, drive.opened.clone()));
    let Some((key, planned)) = found else {
        if of_run {
            model.driver.kept.put_away(hash, change);
        }
        return opened;
    };
    model.driver.kept.show(key);
    model.driver.forecast = key.forecast;
    model.driver.planner = key.planner;
    model.driver.again = true;
    planned
}

/// Says that the planned ego stands there again.
fn announce_kept_drive(model: &mut Model) {
    if !std::mem::take(&mut model.driver.again) {
        return;
    }
    let Some(planned) = model.planned() else {
        return;
    };
    let (reach, outcome) = (planned.reach(), planned.ended());
    show_reach(model, reach);
    let back = model.look.key(Action::RecordedEgo);
    model.say(format!(
        "the planned ego again: {outcome}; {back} takes it off"
    ));
}

/// Writes the planned ego.
fn save(model: &mut Model) -> Vec<Effect> {
    let files = model.opened.as_deref().and_then(|opened| {
        let planned = opened.planned.as_deref()?;
        Some(DriveFiles {
            key: opened.drive_key()?,
            name: opened.name.clone(),
            scene: opened.scene.clone()?,
            vehicle: planned.vehicle,
            problem: planned.problem,
            folder: model.config.pictures.clone(),
        })
    });
    match files {
        Some(files) => vec![SaveDrive(Box::new(files)).into()],
        None => {
            let why = model.unplanned();
            model.say(format!("nothing to write: {why}"));
            Vec::new()
        }
    }
}
