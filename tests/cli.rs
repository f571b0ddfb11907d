//! The headless commands, through the program itself.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "cli/accounts.rs"]
mod accounts;
#[path = "cli/ask.rs"]
mod ask;
#[path = "cli/bare.rs"]
mod bare;
#[path = "cli/batches.rs"]
mod batches;
#[path = "cli/bulk.rs"]
mod bulk;
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
#[path = "cli/evaluate.rs"]
mod evaluate;
#[path = "cli/extended.rs"]
mod extended;
#[path = "cli/generate.rs"]
mod generate;
#[path = "cli/going_on.rs"]
mod going_on;
#[path = "cli/hostile.rs"]
mod hostile;
#[path = "cli/inspecting.rs"]
mod inspecting;
#[path = "cli/interrupted.rs"]
mod interrupted;
#[path = "cli/json.rs"]
mod json;
#[path = "cli/kept.rs"]
mod kept;
#[path = "cli/killed.rs"]
mod killed;
#[path = "cli/long_jobs.rs"]
mod long_jobs;
#[path = "cli/look.rs"]
mod look;
#[path = "cli/manual.rs"]
mod manual;
#[path = "cli/metrics.rs"]
mod metrics;
#[path = "cli/models.rs"]
mod models;
#[path = "cli/older_store.rs"]
mod older_store;
#[path = "cli/paused.rs"]
mod paused;
#[path = "cli/piped.rs"]
mod piped;
#[path = "cli/plan.rs"]
mod plan;
#[path = "cli/planted.rs"]
mod planted;
#[path = "cli/prompts.rs"]
mod prompts;
#[path = "cli/protobuf.rs"]
mod protobuf;
#[path = "cli/ratings.rs"]
mod ratings;
#[path = "cli/reading.rs"]
mod reading;
#[path = "cli/refused.rs"]
mod refused;
#[path = "cli/remote.rs"]
mod remote;
#[path = "cli/render.rs"]
mod render;
#[path = "cli/reports.rs"]
mod reports;
#[path = "protobuf/rich.rs"]
mod rich;
#[path = "cli/secrets.rs"]
mod secrets;
#[path = "cli/stored.rs"]
mod stored;
mod support;
#[path = "cli/tasks.rs"]
mod tasks;
#[path = "cli/thresholds.rs"]
mod thresholds;

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
