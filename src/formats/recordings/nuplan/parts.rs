//! Which part of a log is meant: ten seconds around a track, a scene, or what is around one of its tokens.

use super::log::{EGO, Log, id_of};
use super::sqlite::{Database, Token};
use crate::commonroad::ReadError;
use crate::recordings::report::Report;
use crate::recordings::windows::{self, WindowRequest};

/// The vehicle that records, as a track.
pub const RECORDER: &str = "ego";

/// So much before the moment of a token belongs to it, seconds.
const BEFORE: f64 = 3.0;

/// So many scenes of a log are named in a message.
const MAX_LISTED: usize = 5;

/// A part of a log.
#[derive(Debug)]
pub struct Part {
    /// The sweeps, in order.
    pub sweeps: Vec<usize>,
    /// The id of the ego.
    pub ego: i64,
}

/// The part that an address names.
///
/// # Errors
/// It names none, or one that is not there.
pub fn part(
    said: &str,
    log: &Log,
    database: &Database,
    report: &Report,
) -> Result<Part, ReadError> {
    if let Some(scene) = said.strip_prefix("scene=") {
        return self::scene(scene, log, report);
    }
    if let Some(token) = token(said) {
        return around(token, said, log, database, report);
    }
    let wanted = WindowRequest::parse(said, report).map_err(|_| {
        report.fail(format!(
            "`{said}` is no part of a log; name ten seconds around a track as `track=ego@34.0s`, a whole track as `track=12`, a scene as `scene=NAME`, or the token of a sweep, a scene or a scenario tag"
        ))
    })?;
    let ego = track(&wanted.track, log, report)?;
    let sweeps = match wanted.start {
        Some(start) => log.between(start, start + windows::LENGTH),
        None if ego == EGO => (0..log.sweeps.len()).collect(),
        None => there(ego, log, database)?,
    };
    if sweeps.is_empty() {
        let message = format!(
            "no sweep in that window; the log takes {:.1} s",
            log.duration()
        );
        return Err(report.fail(message));
    }
    Ok(Part { sweeps, ego })
}

/// A token, as the data set writes them.
fn token(said: &str) -> Option<Token> {
    let is_token = said.len() == 16 && said.bytes().all(|b| b.is_ascii_hexdigit());
    is_token.then(|| Token::from_str_radix(said, 16).ok())?
}

/// The id of a track: by its number or its token.
fn track(said: &str, log: &Log, report: &Report) -> Result<i64, ReadError> {
    let last = id_of(log.tracks.len()) - 1;
    let number = said
        .parse::<i64>()
        .ok()
        .filter(|id| (EGO..=last).contains(id));
    let named = token(said).and_then(|token| log.by_track.get(&token));
    match (said, number, named) {
        (RECORDER, ..) => Ok(EGO),
        (_, Some(id), _) => Ok(id),
        (_, _, Some(place)) => Ok(id_of(*place)),
        _ => Err(report.fail(format!(
            "no track `{said}`; it has {RECORDER}, and tracks {} to {last}",
            EGO + 1
        ))),
    }
}

/// The sweeps from the first to the last one with a track.
fn there(id: i64, log: &Log, database: &Database) -> Result<Vec<usize>, ReadError> {
    let place = usize::try_from(id - EGO - 1).unwrap_or(usize::MAX);
    let Some(track) = log.tracks.get(place) else {
        return Ok(Vec::new());
    };
    let (mut first, mut last) = (usize::MAX, 0);
    let columns = &["token", "lidar_pc_token", "track_token"];
    database.with_token(
        "lidar_box",
        columns,
        "track_token",
        track.token,
        &mut |row| {
            if let Some(sweep) = log.by_sweep.get(&row.token(1)?) {
                (first, last) = (first.min(*sweep), last.max(*sweep));
            }
            Ok(())
        },
    )?;
    Ok((first..=last).collect())
}

fn scene(said: &str, log: &Log, report: &Report) -> Result<Part, ReadError> {
    let found = log
        .scenes
        .iter()
        .find(|(id, name)| name == said || token(said) == Some(*id));
    let Some((id, _)) = found else {
        let names = log
            .scenes
            .iter()
            .take(MAX_LISTED)
            .map(|(_, name)| name.as_str());
        let names: Vec<&str> = names.collect();
        let more = match log.scenes.len() - names.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let message = if names.is_empty() {
            format!("no scene `{said}`; it has none")
        } else {
            format!("no scene `{said}`; it has {}{more}", names.join(", "))
        };
        return Err(report.fail(message));
    };
    of_scene(*id, log)
        .ok_or_else(|| report.fail(format!("scene `{said}` has no sweep in table lidar_pc")))
}

fn of_scene(id: Token, log: &Log) -> Option<Part> {
    let sweeps = log
        .sweeps
        .iter()
        .zip(0..)
        .filter_map(|(sweep, place)| (sweep.scene == Some(id)).then_some(place));
    let sweeps: Vec<usize> = sweeps.collect();
    (!sweeps.is_empty()).then_some(Part { sweeps, ego: EGO })
}

/// What is around a sweep or a tag of one; or a scene.
fn around(
    id: Token,
    said: &str,
    log: &Log,
    database: &Database,
    report: &Report,
) -> Result<Part, ReadError> {
    if let Some(scene) = of_scene(id, log) {
        return Ok(scene);
    }
    let mut sweep = log.by_sweep.get(&id).copied();
    if sweep.is_none() && database.has("scenario_tag") {
        let columns = &["token", "lidar_pc_token"];
        database.with_token("scenario_tag", columns, "token", id, &mut |row| {
            sweep = log.by_sweep.get(&row.token(1)?).copied();
            Ok(())
        })?;
    }
    let Some(sweep) = sweep else {
        let message =
            format!("no sweep, scene or scenario tag with a sweep has the token `{said}`");
        return Err(report.fail(message));
    };
    let start = (log.seconds(sweep) - BEFORE)
        .min(log.duration() - windows::LENGTH)
        .max(0.0);
    Ok(Part {
        sweeps: log.between(start, start + windows::LENGTH),
        ego: EGO,
    })
}
