//! The single message of 2020a.

use super::checks::{self, ONE};
use super::elements::Elements;
use super::report::{FieldPath, Report};
use super::shapes::region;
use super::words::{ENVIRONMENT_2020A, OBSTACLE_TYPES};
use super::{header, obstacles, place, planning, road};
use crate::commonroad::ReadError;
use crate::commonroad::builder::ScenarioBuilder;
use nearmiss_scene::scenario::{ContentHash, Scenario};

/// Reads the message.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<Scenario, ReadError> {
    let report = Report::about(file);
    let root = FieldPath::root(&report, "");
    let mut builder = ScenarioBuilder::default();
    let (mut header, mut tags, mut location) = (None, None, None);
    let mut elements = Elements::new(&root, &mut builder);
    root.each_field(bytes, |field| match field.number {
        1 => {
            let at = root.field("information");
            at.part(field, &mut header, header::of_2020a)
        }
        2 => {
            let at = root.field("scenario_tags");
            at.part(field, &mut tags, |at, m| Ok(planning::tags(at, m)))
        }
        3 => {
            let at = root.field("location");
            at.part(field, &mut location, |at, m| {
                place::location(at, m, &ENVIRONMENT_2020A)
            })
        }
        4 => elements.add("lanelets", field, |builder, at, m| {
            builder.lanelet(at, road::lanelet(at, m)?);
            Ok(())
        }),
        5 => elements.add("traffic_signs", field, |builder, at, m| {
            builder.sign(at, road::sign(at, m)?);
            Ok(())
        }),
        6 => elements.add("traffic_lights", field, |builder, at, m| {
            builder.light(at, road::light(at, m)?);
            Ok(())
        }),
        7 => elements.add("intersections", field, |builder, at, m| {
            builder.intersection(at, road::intersection(at, m)?);
            Ok(())
        }),
        8 => elements.add("static_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::fixed(at, m, region)?);
            Ok(())
        }),
        9 => elements.add("dynamic_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::moving(at, m, region)?);
            Ok(())
        }),
        10 => elements.add("environment_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::environment(at, m, OBSTACLE_TYPES)?);
            Ok(())
        }),
        11 => elements.add("phantom_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::phantom(at, m)?);
            Ok(())
        }),
        12 => elements.add("planning_problems", field, |builder, at, m| {
            builder.problem(at, planning::problem(at, m)?);
            Ok(())
        }),
        _ => {
            root.skip_unknown(field);
            Ok(())
        }
    })?;
    let header = root.need("information", header)?;
    builder.tags = root.need("scenario_tags", tags)?;
    builder.location = Some(root.need("location", location)?);
    let scenario = builder.finish(header, ContentHash::digest(bytes));
    Ok(checks::finish(report, &ONE, scenario))
}
