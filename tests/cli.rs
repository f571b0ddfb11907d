//! The headless commands, through the program itself.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[cfg(unix)]
#[path = "cli/answer_page.rs"]
mod answer_page;
#[cfg(unix)]
#[path = "cli/answer_pictures.rs"]
mod answer_pictures;
#[path = "cli/ask.rs"]
mod ask;
#[path = "cli/attempts.rs"]
mod attempts;
#[path = "cli/batches.rs"]
mod batches;
#[path = "cli/bundled_parts.rs"]
mod bundled_parts;
#[path = "cli/bundles.rs"]
mod bundles;
#[path = "cli/bundles_refused.rs"]
mod bundles_refused;
#[path = "cli/chat_pictures.rs"]
mod chat_pictures;
#[path = "cli/chats.rs"]
mod chats;
#[path = "cli/claims.rs"]
mod claims;
#[path = "cli/convert.rs"]
mod convert;
#[path = "cli/crashed.rs"]
mod crashed;
#[path = "cli/doctor.rs"]
mod doctor;
#[path = "cli/egos.rs"]
mod egos;
#[path = "protobuf/encode.rs"]
mod encode;
#[path = "cli/escape_sequences.rs"]
mod escape_sequences;
#[path = "cli/evaluate.rs"]
mod evaluate;
#[path = "cli/evaluate_bulk.rs"]
mod evaluate_bulk;
#[path = "cli/evaluate_resume.rs"]
mod evaluate_resume;
#[path = "cli/experiments.rs"]
mod experiments;
#[path = "cli/extreme_scenarios.rs"]
mod extreme_scenarios;
#[path = "cli/failing_servers.rs"]
mod failing_servers;
#[path = "cli/find.rs"]
mod find;
#[path = "cli/generate.rs"]
mod generate;
#[path = "cli/generate_resume.rs"]
mod generate_resume;
#[path = "cli/generate_together.rs"]
mod generate_together;
#[path = "cli/hostile.rs"]
mod hostile;
#[path = "cli/index.rs"]
mod index;
#[path = "cli/inspecting.rs"]
mod inspecting;
#[path = "cli/interrupted.rs"]
mod interrupted;
#[path = "cli/json.rs"]
mod json;
#[path = "cli/kept_files.rs"]
mod kept_files;
#[path = "cli/killed.rs"]
mod killed;
#[path = "cli/known_models.rs"]
mod known_models;
#[path = "cli/long_jobs.rs"]
mod long_jobs;
#[path = "cli/manual.rs"]
mod manual;
#[path = "cli/mcp.rs"]
mod mcp;
#[path = "cli/mcp_files.rs"]
mod mcp_files;
#[path = "cli/mcp_http.rs"]
mod mcp_http;
#[path = "cli/mcp_jobs.rs"]
mod mcp_jobs;
#[path = "cli/metrics.rs"]
mod metrics;
#[path = "cli/models.rs"]
mod models;
#[path = "cli/models_and_costs.rs"]
mod models_and_costs;
#[path = "cli/monitor.rs"]
mod monitor;
#[path = "cli/older_store.rs"]
mod older_store;
#[path = "cli/pictures.rs"]
mod pictures;
#[path = "cli/piped.rs"]
mod piped;
#[path = "cli/plan.rs"]
mod plan;
#[cfg(unix)]
#[path = "cli/planner_egos.rs"]
mod planner_egos;
#[path = "cli/planner_troubles.rs"]
mod planner_troubles;
#[path = "cli/planners.rs"]
mod planners;
#[path = "cli/prompts.rs"]
mod prompts;
#[path = "cli/protobuf.rs"]
mod protobuf;
#[path = "cli/ratings.rs"]
mod ratings;
#[path = "cli/reading.rs"]
mod reading;
#[path = "cli/recording_task.rs"]
mod recording_task;
#[path = "cli/recordings.rs"]
mod recordings;
#[path = "cli/refused.rs"]
mod refused;
#[path = "cli/remote.rs"]
mod remote;
#[path = "cli/render.rs"]
mod render;
#[cfg(unix)]
#[path = "cli/report_axes.rs"]
mod report_axes;
#[path = "cli/reports.rs"]
mod reports;
#[path = "cli/requirements.rs"]
mod requirements;
#[path = "protobuf/rich.rs"]
mod rich;
#[path = "cli/same_names.rs"]
mod same_names;
#[path = "cli/secrets.rs"]
mod secrets;
#[path = "cli/shards.rs"]
mod shards;
#[cfg(unix)]
#[path = "cli/simulators.rs"]
mod simulators;
#[path = "cli/splits.rs"]
mod splits;
#[path = "cli/stored.rs"]
mod stored;
mod support;
#[path = "cli/tasks.rs"]
mod tasks;
#[path = "cli/themes_and_keys.rs"]
mod themes_and_keys;
#[path = "cli/thresholds.rs"]
mod thresholds;
#[path = "cli/tools.rs"]
mod tools;
#[path = "cli/tools_unstreamed.rs"]
mod tools_unstreamed;
#[path = "cli/trajectory_pictures.rs"]
mod trajectory_pictures;
#[path = "cli/tune.rs"]
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
