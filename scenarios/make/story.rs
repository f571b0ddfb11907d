//! A scenario before it is a file: the road, everybody on it, the ego's drive, and how it is meant to end.

use std::collections::BTreeMap;
use std::error::Error;

use nearmiss::formats::{commonroad, write_recording};
use nearmiss::geometry::{Footprint, Shape};
use nearmiss::scenario::{
    ContentHash, Goal, Header, LaneletNetwork, Location, Obstacle, ObstacleRole, PlanningProblem,
    Position, Quantity, Sample, Scenario, StateField, Steps, Track,
};

use super::cast::state;
use super::drive::{DT, Drive, Moment};
use super::{place, rounded};

/// How a scenario is meant to end for the ego as recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It hits, or is hit by, this obstacle.
    Collision(i64),
    /// Nothing touches it, but only just.
    NearMiss,
    /// Nothing comes near.
    Safe,
}

/// A scenario as it is told.
#[derive(Debug)]
pub struct Story {
    /// The benchmark id.
    pub name: &'static str,
    /// What happens, in a line.
    pub title: &'static str,
    /// CommonRoad's tags, in the order of its list.
    pub tags: &'static [&'static str],
    /// The road.
    pub network: LaneletNetwork,
    /// Everybody else, recorded at all steps.
    pub obstacles: Vec<Obstacle>,
    /// Id of the planning problem.
    pub ego: i64,
    /// What the ego does.
    pub drive: Drive,
    /// Last time step.
    pub last: usize,
    /// Lanelets to arrive at.
    pub goal: &'static [i64],
    /// How it ends.
    pub outcome: Outcome,
}

/// A scenario as files.
#[derive(Debug)]
pub struct Made {
    /// The benchmark id, also the files' name.
    pub name: &'static str,
    /// What happens, in a line.
    pub title: &'static str,
    /// How it ends.
    pub outcome: Outcome,
    /// The scenario.
    pub xml: Vec<u8>,
    /// The ego's recording.
    pub csv: Vec<u8>,
}

/// The ego's size, metres: what recordings stand for, as they do not carry it.
const EGO: (f64, f64) = (4.508, 1.61);

/// Every file is of this day; a program that writes today's date writes no file twice.
const DATE: &str = "2026-11-20";

/// Steps recorded after the first contact.
const AFTERMATH: usize = 1;

impl Story {
    /// Computes the ego's motion and writes both files.
    pub fn make(self) -> Result<Made, Box<dyn Error>> {
        let mut ego = self.drive.moments(self.last);
        if let Outcome::Collision(with) = self.outcome {
            let contact = self.first_contact(&ego, with)?;
            let contact = contact.ok_or(format!("{}: the ego does not touch {with}", self.name))?;
            ego.truncate(contact + AFTERMATH + 1);
        }
        let csv = recording(self.ego, &ego)?;
        let attributes = [
            ("author", "nearmiss"),
            ("affiliation", "nearmiss, bundled scenarios"),
            ("source", self.title),
            ("date", DATE),
        ];
        let start = &ego[0];
        let mut initial = state(0, start);
        initial.more = vec![
            (
                StateField::YawRate,
                Quantity::Exact(rounded(start.yaw_rate)),
            ),
            // Vehicles do not slide: motion is along the heading.
            (StateField::SlipAngle, Quantity::Exact(0.0)),
        ];
        let steps = i64::try_from(self.last)?;
        let problem = PlanningProblem {
            id: self.ego,
            initial,
            goals: vec![Goal {
                time: Steps {
                    from: steps - 20,
                    to: steps,
                },
                positions: vec![Position::Lanelets(self.goal.to_vec())],
                orientation: None,
                velocity: None,
            }],
        };
        let xml = commonroad::write(&Scenario {
            header: Header {
                other_format: None,
                benchmark_id: self.name.to_string(),
                version: "2020a".into(),
                time_step_size: DT,
                attributes: BTreeMap::from(attributes.map(|(k, v)| (k.into(), v.into()))),
            },
            // Nowhere on Earth.
            location: Some(Location::default()),
            tags: self.tags.iter().map(ToString::to_string).collect(),
            network: self.network,
            obstacles: self.obstacles,
            planning_problems: vec![problem],
            diagnostics: Vec::new(),
            recorded_ego: None,
            hash: ContentHash::digest(b""),
        })?;
        Ok(Made {
            name: self.name,
            title: self.title,
            outcome: self.outcome,
            xml,
            csv,
        })
    }

    fn first_contact(&self, ego: &[Moment], with: i64) -> Result<Option<usize>, Box<dyn Error>> {
        let body = Footprint::new(Shape::rectangle(EGO.0, EGO.1))?;
        let found = self.obstacles.iter().find(|o| o.id == with);
        let other = found.ok_or(format!("{}: no obstacle {with}", self.name))?;
        let shape = other
            .footprint
            .as_ref()
            .ok_or("an obstacle without a body")?;
        Ok((0..).zip(ego).find_map(|(step, moment)| {
            let now = if other.role == ObstacleRole::Static {
                0
            } else {
                step
            };
            let there = other.track().at(now)?.pose;
            let touch = body.at(moment.pose).distance(&shape.at(there)) == 0.0;
            touch.then_some(usize::try_from(step).ok()?)
        }))
    }
}

fn recording(id: i64, moments: &[Moment]) -> Result<Vec<u8>, Box<dyn Error>> {
    let samples = (0..).zip(moments).map(|(step, moment)| Sample {
        step,
        position: place(moment.pose.position),
        heading: Some(rounded(moment.pose.heading)),
        velocity: Some(rounded(moment.velocity)),
        acceleration: Some(rounded(moment.acceleration)),
    });
    Ok(write_recording(
        id,
        &Track::new(samples.collect(), DT, None),
    )?)
}
