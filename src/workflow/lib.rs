//! What the program does, shared by command line and workbench: a request, events on the way, an outcome.
//!
//! - [`find`]: the scenarios in files and folders, and the windows of long recordings
//! - [`read_as_said`]: tables, maps and players as the configuration has them
//! - [`open`]: a scenario with its ego, optionally with a changed scene
//! - [`question`]: a window of a scene as it is asked about; [`span`]: how the window is named
//! - [`ask`]: one question to a model, its answer stored before it is shown
//! - [`batch`]: many questions, stored before they are asked, and resumable
//! - [`read_experiment`]: a batch written down in a file, for others to repeat
//! - [`pack`], [`unpack`]: a batch with its answers as one file, for other machines
//! - [`Selector`]: the scenarios that a filter of the list lets through
//! - [`prepare`]: the planner drives the ego of a planning problem
//! - [`drive`]: who drives, what became of it, and records of it
//! - [`Monitor`]: a judge beside the planner, whose warnings may brake
//! - [`VariantOrigin`]: a saved variant with its manifest, and where its original is
//! - [`generate`]: changes one obstacle's motion until it endangers the planned ego
//! - [`variant`]: what was made of a scenario, records of it, and its files
//! - [`read_index`]: the windows of a corpus, by manoeuvre, road and severity
//! - [`search_index`]: the windows of an index that a filter lets through
//! - [`rates`], [`foreseeability`]: how often the egos of an index meet a manoeuvre; [`rates_like`]: one as extreme as in a
//!   scenario, and who avoids it
//! - [`write_filter`]: a model writes the filter that a sentence means
//! - [`answer_page`]: the answers of a report with their texts, claims and pictures
//! - [`count_claims`]: the claims of stored answers that were not checked yet
//! - [`TruthSearch`]: what is true about stored answers
//! - [`SecondReader`]: a model puts sentences that rules do not understand into claims
//! - [`tune`]: better templates from wrong answers of a dev split
//! - [`annex`]: planners held to a requirement, beside drivers and baselines
//! - [`convert`]: a scenario in another format
//! - [`ToldStory`]: what happened, and who would have avoided it
//! - [`tables`]: measures, lanes and windows, a row each
//! - [`journal`]: what a job over many files has finished, so that a run that was killed continues
//!
//! Computations run on the calling thread and call `on_event` there. They end early when their
//! [`Cancel`](nearmiss_drive::planner::Cancel) is set, even inside a planning cycle, and then have no outcome. Work that waits
//! for a server is a future: dropping it cancels the request.

pub mod annex;
mod answer_page;
mod ask;
mod ask_document;
pub mod batch;
mod bundle;
pub mod convert;
pub mod drive;
mod examples;
mod experiment;
mod generate;
pub mod journal;
mod listing;
mod monitor;
mod open;
mod original;
mod overview;
mod plan;
mod question;
mod rate;
mod reading;
mod scenario_filter;
mod second_reader;
mod simulator_export;
pub mod span;
mod stand_in;
mod story;
pub mod tables;
mod truth;
pub mod tune;
pub mod variant;

pub use answer_page::{answer_page, count_claims, files_of_batches, is_unchecked};
pub use ask::{AskOutcome, AskRequest, Models, Server, ask, parameters};
pub use ask_document::{AskDocument, cost_at_current_prices, missing_verdict, rfc3339};
pub use bundle::{
    BUNDLE_FORMAT, BundleError, Manifest, Member, PackRequest, Packed, PackedScenario,
    UnpackRequest, Unpacked, pack, read_manifest, stored_bundle, unpack,
};
pub use examples::example_runs;
pub use experiment::{
    ConfigurationProgress, ExperimentAxis, ExperimentContext, ExperimentFile, ExperimentProgress,
    FolderOfExperiments, PreparedExperiment, WriteExperimentError, add_experiment_file,
    batch_request, complete_experiment, configured_experiment, count_reasons, experiment_among,
    experiment_axes, experiment_facts, experiment_from_request, experiment_schema, experiment_toml,
    experiments_in, find_scenarios, hashed_name, hashes_in, is_experiment_file, prepare_experiment,
    read_experiment, scenario_hashes, selected, template_pins, write_experiment,
};
pub use generate::{
    AttackSource, AttackWriter, GenerateEvent, GenerateRequest, Generation, ModelWriter, generate,
};
pub use listing::{
    FoundWindow, FoundWindows, INDEX_RADIUS, IndexSearch, SearchError, checked_filter, find,
    find_in_pieces, index_parts, read_index, search_index,
};
pub use monitor::{
    Incident, Monitor, MonitorAnswer, MonitorCost, MonitorReport, Warning as MonitorWarning,
};
pub use open::{MissingEgo, OpenError, OpenRequest, OpenedScene, open, scene_with_ego};
pub use original::{
    VariantOrigin, VariantProofs, VerifiedCertificate, is_unchanged, verify_variant,
};
pub use overview::{Overview, ScenarioRow};
pub use plan::{
    PlanError, PlanEvent, PlanOutcome, PlanRequest, PlannerFailure, PreparedPlan, prepare,
    prepare_beside, prepare_opened, prepare_read,
};
pub use question::{DescribedWindow, QuestionRequest, described, question};
pub use rate::{
    EventLine, IndexedEvents, JudgedFrom, Rate, RateLike, ScenarioEvent, events_that_fit,
    foreseeability, rates, rates_like, read_events, scenario_events,
};
pub use reading::{named_tables, read_as_said};
pub use scenario_filter::event_terms::EventFilter;
pub use scenario_filter::selector::{FilterError, FilterRequest, WrittenFilter, write_filter};
pub use scenario_filter::{
    Agreement, Facts, Filter, Filterable, HEADLINE, Indexed, Matching, Number, Property, Selector,
    TERMS, Tally, Verdicts, WordMatch, country_code, nearest,
};
pub use second_reader::{ReadText, SecondEstimate, SecondReader, SecondReading};
pub use simulator_export::{ExportRequest, SimulatedEgo, export_to_simulator, scene_to_export};
pub use stand_in::StandIn;
pub use story::ToldStory;
pub use truth::{BatchLabels, StoredQuestion, TruthChoice, TruthSearch, asked_as, batch_labels};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
