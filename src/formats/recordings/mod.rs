//! Recordings of other data sets, as scenarios: Waymo Open Motion, Argoverse 2, nuPlan, levelXdata,
//! SUMO and OpenSCENARIO.
//!
//! Each reader translates a file into a [`assembly::Map`] and [`assembly::RecordedTrack`]s; [`assembly::assemble`]
//! makes the scenario of them, with the recording's own ego, a planning problem and the checks that every format gets.

mod argoverse;
mod assembly;
mod columns;
mod crossing;
mod ids;
mod lane_shape;
mod lanelet2;
mod leftovers;
mod levelx;
mod named_files;
mod nuplan;
mod opendrive;
mod openscenario;
mod repeated;
mod report;
mod sizes;
mod steps;
mod sumo;
mod user_maps;
mod utm;
mod waymo;
mod windows;

use std::path::Path;

use super::address::Address;
use super::commonroad::ReadError;
pub(super) use argoverse::{Argoverse, columns as parquet_columns};
pub(super) use columns::of as columns_of;
pub(super) use levelx::{LevelX, missing_columns};
pub(super) use nuplan::NuPlan;
pub(super) use openscenario::OpenScenario;
pub(super) use sumo::Sumo;
pub use user_maps::look_for_maps_in;
pub(super) use waymo::Waymo;
pub use windows::LongRecording;

/// The file of a format in which each file is one scenario.
///
/// # Errors
/// A part of it is named.
pub(super) fn whole_file(address: &Address) -> Result<&Path, ReadError> {
    let (file, Some(part)) = (&address.file, &address.part) else {
        return Ok(&address.file);
    };
    let file = file.display();
    let message = format!("{file} is one scenario; name it without `#{part}`");
    Err(report::Report::about(format!("{file}#{part}")).fail(message))
}
