//! The headless commands, through the program itself.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod annex;
#[cfg(unix)]
mod answer_page;
#[cfg(unix)]
mod answer_pictures;
mod ask;
mod attempts;
mod batches;
mod bundled_parts;
mod bundles;
mod bundles_refused;
mod chat_pictures;
mod chats;
mod check;
mod claims;
mod convert;
mod crashed;
mod cropped;
mod doctor;
mod drivers;
mod egos;
#[path = "../domain/protobuf/encode.rs"]
mod encode;
mod english;
mod escape_sequences;
mod evaluate;
mod evaluate_bulk;
mod evaluate_resume;
mod experiments;
mod extreme_scenarios;
mod failing_servers;
mod families;
mod find;
mod generate;
mod generate_resume;
mod generate_together;
mod hard;
mod hostile;
mod hugging_face;
mod index;
mod inspecting;
mod interrupted;
mod json;
mod kept_files;
mod killed;
mod known_models;
mod long_jobs;
mod manual;
mod mcp;
mod mcp_files;
mod mcp_http;
mod mcp_jobs;
mod metrics;
mod models;
mod models_and_costs;
mod monitor;
mod older_store;
mod own_measures;
mod pages;
mod pictures;
mod piped;
mod plan;
#[cfg(unix)]
mod planner_egos;
mod planner_troubles;
mod planners;
mod prompts;
mod protobuf;
mod rate_like;
mod ratings;
mod reading;
mod recording_task;
mod recordings;
mod reference;
mod refused;
mod remote;
mod render;
#[cfg(unix)]
mod report_axes;
mod reports;
mod requirements;
#[path = "../domain/protobuf/rich.rs"]
mod rich;
mod same_names;
mod secrets;
mod shards;
#[cfg(unix)]
mod simulators;
mod splits;
mod stored;
#[path = "../support/mod.rs"]
mod support;
#[cfg(unix)]
mod task_pages;
mod tasks;
mod themes_and_keys;
mod thresholds;
mod tools;
mod tools_unstreamed;
mod tracks;
mod trajectory_pictures;
mod tune;

/// The bundled scenarios and whether the ego collides in them.
const BUNDLED: [(&str, bool); 8] = [
    ("ZAM_HardBraking-1_1_T-1", true),
    ("ZAM_CutIn-1_1_T-1", false),
    ("ZAM_RedLight-1_1_T-1", true),
    ("ZAM_Overtaking-1_1_T-1", false),
    ("ZAM_Pedestrian-1_1_T-1", false),
    ("ZAM_Merge-1_1_T-1", false),
    ("ZAM_RightTurn-1_1_T-1", false),
    ("ZAM_JamTail-1_1_T-1", false),
];

const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";

/// The text of a bundled scenario's file.
fn bundled_xml(name: &str) -> String {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    std::fs::read_to_string(folder.join(format!("{name}.xml"))).unwrap()
}

/// Its recorded ego.
fn bundled_ego(name: &str) -> String {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    std::fs::read_to_string(folder.join(format!("{name}.ego_trajectory.csv"))).unwrap()
}
