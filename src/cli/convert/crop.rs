//! Which part of scenarios is converted: options for time, area and obstacles.

use nearmiss_scene::scenario::Around;
use nearmiss_workflow::convert::Part;
use serde::Serialize;

use crate::span::{At, moment};

/// What of scenarios is kept.
#[derive(Debug, Clone, clap::Args, Serialize)]
#[command(next_help_heading = "Crop")]
pub(super) struct CropOptions {
    /// Drop everything before a time step (20) or a time in seconds (2s)
    ///
    /// Steps keep their numbers, but start at 0 in OpenSCENARIO, with --schema, and when a table is read again.
    #[arg(long, value_name = "STEP|SECONDS", allow_negative_numbers = true, value_parser = moment)]
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<At>,
    /// Drop everything after a time step (20) or a time in seconds (2s); this step is kept.
    #[arg(long, value_name = "STEP|SECONDS", allow_negative_numbers = true, value_parser = moment)]
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<At>,
    /// Keep what comes within METRES of the ego's path (ego:60m) or of a point (12.5,-3:60m)
    ///
    /// Keeps lanelets, and obstacles with all their states, between --from and --to.
    #[arg(long, value_name = "ego|X,Y:METRES", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    around: Option<Around>,
    /// Keep only these obstacles, separated by commas.
    #[arg(
        long,
        value_name = "ID",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    keep: Vec<i64>,
    /// Drop these obstacles, separated by commas.
    #[arg(
        long,
        value_name = "ID",
        value_delimiter = ',',
        allow_negative_numbers = true,
        conflicts_with = "keep"
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    drop: Vec<i64>,
}

impl CropOptions {
    /// What was said.
    pub fn part(&self) -> Part {
        Part {
            from: self.from,
            to: self.to,
            around: self.around,
            keep: self.keep.iter().copied().collect(),
            drop: self.drop.iter().copied().collect(),
        }
    }
}
