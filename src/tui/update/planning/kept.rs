//! Kept planner drives: shown without planning again, and exported.

use super::super::super::action::Action;
use super::super::super::loaded::{DriveFiles, DriveKey, Opened};
use super::super::super::message::Effect;
use super::super::super::model::{Model, OpenId};
use super::super::super::tasks::planning::SaveDrive;
use super::{show_reach, take};

/// The drive that the planner would make now, if it was made before.
pub fn kept(model: &Model) -> Option<Box<Opened>> {
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
pub fn show(model: &mut Model) -> Option<Vec<Effect>> {
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
pub fn instead(
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
pub fn told(model: &mut Model) {
    if !std::mem::take(&mut model.driver.again) {
        return;
    }
    let Some(planned) = model.planned() else {
        return;
    };
    let (reach, outcome) = (planned.reach(), planned.ended());
    show_reach(model, reach);
    let back = model.look.key(Action::RecordedEgo);
    model.tell(format!(
        "the planned ego again: {outcome}; {back} takes it off"
    ));
}

/// Writes the planned ego.
pub fn save(model: &mut Model) -> Vec<Effect> {
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

/// A planned ego was written, or not.
pub fn saved(model: &mut Model, key: DriveKey, result: Result<String, String>) {
    match result {
        Ok(files) => {
            model.driver.kept.saved(key, &files);
            model.say(format!("saved as {files}"));
        }
        Err(error) => model.complain(format!("the planned ego is not written: {error}")),
    }
}
