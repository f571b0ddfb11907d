//! Tables of predicted trajectories: a track is a road user and a mode, with the probability of it where there is one.

use std::path::Path;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::Diagnostic;

use super::columns::Role;
use super::gather::Rows;
use super::table::{Recorded, Said};
use super::{Plan, options};
use crate::commonroad::ReadError;
use crate::recordings::Report;

/// A predicted trajectory.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Forecast {
    /// The obstacle or the ego, where the track's name is a number.
    pub id: Option<i64>,
    /// The scenario that the table names; empty where it has one.
    pub scenario: String,
    /// How likely it is, from 0 to 1.
    pub probability: Option<f64>,
    /// Metres, in order of time.
    pub points: Vec<Point>,
}

impl Forecast {
    /// How clearly it is drawn: the less likely, the fainter, but never unseen.
    #[must_use]
    pub fn opacity(&self) -> f64 {
        const LEAST: f64 = 0.15;
        LEAST + (1.0 - LEAST) * self.probability.unwrap_or(1.0)
    }
}

/// Reads the trajectories of a table, with all that is odd about it.
///
/// # Errors
/// It is no table of tracks, a cell is broken, or its places are in degrees, which lie on no plane of a scenario.
pub fn read_forecasts(path: &Path) -> Result<(Vec<Forecast>, Vec<Diagnostic>), ReadError> {
    let report = Report::about(path.display().to_string());
    let plan = Plan::of_file(path, &options(), &report, |_| true)?;
    let plan = plan.ok_or_else(|| {
        report.fail("no table with columns time, id, x and y; --columns ROLE=COLUMN names them")
    })?;
    let missing = plan.columns.missing();
    if !missing.is_empty() {
        plan.check(&report)?;
    }
    let mut rows = Rows::default();
    plan.rows(path, &report, &mut rows)?;
    let probabilities = rows.firsts(Role::Probability);
    let wrong = |p: &&Option<f64>| p.is_some_and(|p| !(0.0..=1.0).contains(&p));
    if let Some(Some(wrong)) = probabilities.iter().find(wrong) {
        return Err(report.fail(format!("a probability of {wrong}; expected 0 to 1")));
    }
    let said = Said {
        // The user need not say what counts them.
        is_order: true,
        ..Said::default()
    };
    let recorded = Recorded::new(rows, &plan.columns, said, report.file())?;
    if recorded.plane.is_some() {
        return Err(report.fail("places in degrees; write x and y in metres of the scenario"));
    }
    let tracks = recorded.tracks.into_iter().zip(probabilities);
    let forecasts = tracks.map(|(track, probability)| Forecast {
        id: track.id_of_forecast(),
        points: track.states.iter().map(|state| state.position).collect(),
        scenario: track.scenario,
        probability,
    });
    Ok((forecasts.collect(), recorded.diagnostics))
}
