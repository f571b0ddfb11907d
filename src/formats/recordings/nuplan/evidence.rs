//! What a file is that may be a log of nuPlan: told by its first bytes and the names of its tables.

use std::path::Path;

use super::sqlite::{Database, MAGIC, named};
use crate::commonroad::{ReadError, beginning_of_file};
use crate::recordings::report::Report;
use crate::recordings::user_maps::has_extension;

/// What a SQLite file is.
pub enum Evidence {
    /// A log.
    Log,
    /// Its tables cannot be read.
    Damaged(ReadError),
    /// A GeoPackage, such as a map.
    Map,
    /// Answers that this program keeps.
    Store,
    /// A bag of ROS 2.
    Bag,
    /// Something else with these tables.
    Other(Vec<String>),
}

/// Tables that a log has, and hardly another file has all of.
const TABLES: [&str; 3] = ["lidar_pc", "ego_pose", "lidar_box"];

/// Tables of the answers that this program keeps.
const OWN: [&str; 2] = ["runs", "batches"];

/// Tables of a bag of ROS 2.
const BAG: [&str; 2] = ["topics", "messages"];

/// Whether a file is named or begins like one, also if it is none: what is wrong with it is said here.
pub fn is_named_or_begins_so(path: &Path, head: &[u8]) -> bool {
    // XML and the like under another name is read as what it is.
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let is_xml = text.trim_ascii_start().starts_with(b"<");
    let named = has_extension(path, "db") || has_extension(path, "gpkg");
    head.starts_with(MAGIC) || named && !is_xml
}

/// What a SQLite file is.
pub fn of(path: &Path) -> Evidence {
    let database = match Database::open(path) {
        Ok(database) => database,
        Err(error) => return Evidence::Damaged(error),
    };
    if TABLES.iter().all(|table| database.has(table)) {
        return Evidence::Log;
    }
    if database.has("gpkg_contents") {
        Evidence::Map
    } else if OWN.iter().all(|table| database.has(table)) {
        Evidence::Store
    } else if BAG.iter().all(|table| database.has(table)) {
        Evidence::Bag
    } else {
        Evidence::Other(database.tables().to_vec())
    }
}

/// Refuses what is no log, and says what it is.
pub fn check(path: &Path) -> Result<(), ReadError> {
    let report = Report::about(path.display().to_string());
    let wants =
        "a nuPlan log is a SQLite file with the tables lidar_pc, ego_pose, lidar_box and others";
    let head = beginning_of_file(path, MAGIC.len())
        .map_err(|error| report.fail(format!("{error}; {wants}")))?;
    if !head.starts_with(MAGIC) {
        return Err(report.fail(format!("not a SQLite file; {wants}")));
    }
    let message = match of(path) {
        Evidence::Log => return Ok(()),
        Evidence::Damaged(error) => return Err(error),
        Evidence::Map => {
            "a GeoPackage, not a recording; name a nuPlan log (`*.db`), which finds its map where `nearmiss help scenarios` says"
                .to_string()
        }
        Evidence::Store => {
            "a store of answers of nearmiss, not a recording; `nearmiss report` reads it".into()
        }
        Evidence::Bag => {
            "a bag of ROS 2, not a scenario; `nearmiss help scenarios` lists the formats that are read".into()
        }
        Evidence::Other(tables) if tables.is_empty() => {
            format!("a SQLite file without tables; {wants}")
        }
        Evidence::Other(tables) => {
            format!("a SQLite file with the tables {}; {wants}", named(&tables))
        }
    };
    Err(report.fail(message))
}
