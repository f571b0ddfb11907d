//! A workbench for safety-critical driving scenarios: reading, measuring, describing, asking, comparing.
//!
//! The manual for users is in [`docs`]; `nearmiss help TOPIC` prints the same pages. This page is for those who
//! change the program.
//!
//! # How data flows
//!
//! ```text
//! formats ─► scenario ─► metrics ─► description ─► prompts ─► llm ─► verdict ─┐
//!               │           │                                                 ▼
//!               │           ├──► judge: the right answer ───────────────► evaluation ─► store
//!               │           ├──► render: maps, plots, figures                 ▲         reports
//!               ▼           ▼                                                 │
//!            planner ─► simulation ─► generation: dangerous variants ─────────┘
//!
//!  workflow: open, ask, batch, plan and generate, once for cli and tui; settings tell what
//!  the user wants; geometry and system lie beneath
//! ```
//!
//! [`formats`] reads a file; it becomes a [`scenario::Scenario`], and with an ego a [`scenario::Scene`], on which
//! everything else works. [`metrics`] reads numbers off it and [`description`] puts a window of it into words;
//! [`prompts`] wraps the words into messages, [`llm`] sends them, and [`verdict`] reads the answer. [`judge`] answers
//! the same questions from geometry. [`tools`] computes for models that ask for numbers. [`evaluation`] joins these
//! parts: it runs a case from end to end and keeps it in the [`store`]. [`paper`] compares its results with those of the
//! paper "From Words to Collisions". [`workflow`] is what the program does, once for its two faces, [`cli`] and [`tui`],
//! which do not know each other; `src/main.rs` brings them together.
//!
//! # Where to look
//!
//! | module | the question it answers |
//! |---|---|
//! | [`geometry`] | Do two bodies touch, how far apart are they, when do they meet? |
//! | [`formats`] | Which files are there, what do they say, and where is the ego? |
//! | [`scenario`] | What is on the road, who is where at a step, what is doubtful? |
//! | [`metrics`] | How dangerous is an obstacle at a step, and by which definition? |
//! | [`description`] | How is a window of a scene put into words, and where does each number in them come from? |
//! | [`story`] | What happened, in four sentences of facts? |
//! | [`prompts`] | Which template is used, what does it become, what bounds it? |
//! | [`llm`] | How is a provider asked, what does it cost, what may not leak, what went wrong? |
//! | [`verdict`] | What does an answer say, as data, even where its form is off? |
//! | [`judge`] | What is the right answer? |
//! | [`traffic_rules`] | Which rules of the road hold along a way, and which of them did a drive break? |
//! | [`planner`] | Which motion is the best one now? |
//! | [`simulation`] | How does the ego's drive end, through recorded traffic or through traffic that reacts? |
//! | [`generation`] | Which motion of which obstacle makes this scene dangerous, possible and survivable? |
//! | [`corpus`] | Which windows of which manoeuvres, roads and severities does a corpus hold, and which of them cover it? Which stretches of a long recording are worth looking at? |
//! | [`tools`] | What may a language model compute about a scene, and what is never told to one that is judged? |
//! | [`store`] | What was asked before, what is known of it, who asks it right now? |
//! | [`evaluation`] | What becomes of one case, and of many: truth, claims, statistics, reports? |
//! | [`paper`] | What did the authors of "From Words to Collisions" record and print, and does it agree? |
//! | [`workflow`] | How is a scenario opened, asked about, planned or attacked, with which events on the way? |
//! | [`render`] | What is seen of a map at a step ([`render::scene`]), and how does it look on paper: SVG, PNG, GIF? |
//! | [`settings`] | What does the user want, and from which file and line? |
//! | [`system`] | What does the operating system say, in plain words; how are files written whole, and in which line is a mistake? |
//! | [`cli`] | What does a command do, and with which status does it end? |
//! | [`tui`] | What does a key do, and what is drawn? |
//! | [`docs`] | How is it used? |
//!
//! And by topic:
//!
//! | topic | where |
//! |---|---|
//! | limits of vehicles, the single-track model | [`planner::Limits`], [`planner::Feasibility`] |
//! | is a motion drivable | candidates while planning: `drive/planner/evaluate.rs`; whole motions of anyone: `drive/planner/feasibility.rs` |
//! | planners that are processes: protocol, process, faults | `drive/simulation/external/`; the loop is that of the built-in one |
//! | traffic that reacts to the ego | `drive/simulation/traffic/`: step by step in `mod.rs`, when and how in `reacting.rs` |
//! | limits of people | [`scenario::HumanLimits`] |
//! | lights, signs, right of way | what holds along a way: [`traffic_rules::Regulations`]; how the planner obeys: `drive/planner/pace.rs`; reports: [`traffic_rules::RuleReport`] |
//! | what a key does | `tui/action/default_keys.rs`, then `tui/update/actions.rs` |
//! | exit statuses of commands | `cli/ending.rs` |
//! | centre motion of a changed body | `drive/generation/gate/checks.rs` |
//! | prices of tokens | `ask/llm/price.rs`, with the table in `ask/llm/providers.toml` |
//! | estimates of cost before asking | `study/evaluation/batch/prepared.rs`; for a whole batch [`workflow::batch`] |
//! | drafts of templates | `tui/features/prompt/state.rs`; on disk `tui/session/file.rs` |
//! | pickers: lists filtered by typing | `tui/features/picker.rs` (keys, state), `tui/widgets/picker.rs` (drawing) |
//! | axes of a batch: effort, temperature, form, … | `study/evaluation/settings.rs` |
//! | dev and test: which scenario is where, what is locked | `study/evaluation/batch/matrix.rs`, `test_split.rs`; looks: `store/split.rs`; single answers: `cli/filters.rs` |
//! | parts of a batch become one | `store/intake.rs`; of bundles `workflow/bundle/unpack.rs` |
//! | filter of the scenario list | `workflow/scenario_filter/`; as it is typed: `tui/features/scenarios/mod.rs` |
//! | pictures for models | what is on them and how they are read: `scene/description/picture.rs`; drawn by `render/storyboard.rs`, on demand: `study/evaluation/question.rs`; sent: `ask/llm/dialect/`, each its own way; kept: `store/images.rs` |
//! | answers stored before they are shown | `study/evaluation/run_case.rs` |
//! | page of answers in HTML reports | `study/evaluation/answer_page/`; its texts and pictures: `workflow/answer_page.rs` |
//! | tables over axes | `study/evaluation/report/pivot/` |
//! | figures of reports | `study/evaluation/report/charts.rs`, drawn by `render/chart/` |
//! | whole recordings: safe or of high risk | `scene/judge/mod.rs`; truth by risk score: `study/evaluation/score.rs` |
//! | chats for fine-tuning | which answers: `study/evaluation/training.rs`; files: `cli/export/chat.rs` |
//! | better templates from wrong answers | `workflow/tune/`: rounds in `rounds.rs`, what a proposal must keep in `candidate.rs`; gains: `study/evaluation/statistics/best_of.rs` |
//! | from an experiment file to its batch | `workflow/experiment/prepare.rs`; its screen: `tui/features/experiment/` |
//! | runs over many files that continue | `workflow/journal/`; tables in parts: `cli/parts.rs` |
//! | gate: may a changed motion be written | [`generation::Gate`]; a variant in a file against its original: `workflow/original.rs` |
//! | measures of the user's own | formulas, their units and the registry: `scene/metrics/own/`; `[measure.ID]`: `settings/measures.rs` |
//! | risk score of TTC and MDC | the table `scene/metrics/thresholds/risk.toml`, read by `scene/metrics/risk.rs`; the paper's: `scene/metrics/paper/` |
//! | several attackers | `drive/generation/staging.rs`: one after the other, and when another one is taken |
//! | certificate: how a driver avoids an attack | `drive/generation/certificate.rs`, searched in `drive/generation/evasive_search.rs` |
//! | nouns in tables, CSV, JSON, Parquet, panels and schemas | the struct of the noun, through `record/`: columns from its fields in `reflect.rs` |
//! | settings in files, options, store and lists | a table `fields!`: `study/evaluation/batch/experiment.rs`, read by `record/fields/` |
//! | JSON schemas of outputs | `cli/json/derived.rs` from types, `cli/json/outputs.json` for the rest |
//!
//! # Rules
//!
//! The floors are crates, `src/NAME/Cargo.toml`, and see only those below; this one joins them. What modules of one
//! crate see of each other, and where outside crates such as `ratatui`, `reqwest` or `rusqlite` are at home, is in
//! `tests/architecture/rules.rs`. Every file says in its first line what it is for and has at most 800 lines.
//!
//! In the workbench, data goes one way: a key becomes an action, `tui::update` changes the model and asks for
//! effects, `tui::tasks` works them off and sends messages back, and `tui::views` draws the model without changing it.
//! What opens over the main screen is a `tui::features::Screen`: its state, keys, drawing and footer are one file.
//!
//! What must hold is told by the tests: `tests/architecture/` the rules above, `tests/cli/` the commands,
//! `tests/terminal/` the workbench in a real terminal, `tests/domain/` the numbers.
//! `CONTRIBUTING.md` lists the files to touch for common changes.

pub use nearmiss_ask::{llm, prompts};
pub use nearmiss_base::{geometry, system};
pub use nearmiss_cli as cli;
pub use nearmiss_docs as docs;
pub use nearmiss_drive::{generation, planner, simulation};
pub use nearmiss_formats as formats;
pub use nearmiss_render as render;
pub use nearmiss_scene::{
    corpus, description, judge, metrics, scenario, story, traffic_rules, verdict,
};
pub use nearmiss_settings as settings;
pub use nearmiss_store as store;
pub use nearmiss_study::{evaluation, paper, tools};
pub use nearmiss_tui as tui;
pub use nearmiss_workflow as workflow;

/// That of musl makes threads wait for each other: an index of many files takes twice the time.
#[cfg(target_env = "musl")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;
