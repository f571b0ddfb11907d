//! Messages that `update` receives and effects that it returns, both plain data.

mod computation;
pub mod experiment;
mod job;
pub mod runs;

pub use computation::{Computation, Computed, MeasureId, SeriesId, WindowJudgement};
pub use job::{BatchProgress, JobEvent, JobId, JobRequest, Update};

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use ratatui::layout::Position;

use super::keymap::{Key, Keymap};
use super::loaded::{DriveFiles, DriveKey, Facts, GeneratedVariant, Opened, PictureJob, Source};
use super::theme::Named;
use nearmiss_ask::llm::Discovered;
use nearmiss_ask::prompts::Library;
use nearmiss_formats::{Entry, PassedOver, SearchResults};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::{Config, SavedView, SavedViews, Tags};
use nearmiss_store::{NewRating, Rating, Unrated};
use nearmiss_study::evaluation::Answer;
use nearmiss_workflow::FolderOfExperiments;

/// A message to `update`.
#[derive(Debug)]
pub enum Msg {
    /// A key was pressed.
    Key(Key),
    /// Text was pasted.
    Paste(String),
    /// The mouse did something.
    Mouse(Mouse),
    /// The terminal has this many columns and rows now.
    Resize(u16, u16),
    /// Time passed; sent only while something moves.
    Passed(Duration),
    /// The scenarios were found, or why not.
    Found(Result<SearchResults, String>),
    /// More scenarios were found; the search continues.
    Listed(Vec<Entry>),
    /// The search has ended: what was passed over, or why nothing was found.
    Searched(Result<Vec<PassedOver>, String>),
    /// The user's tags of scenarios, or why they cannot be used.
    Tags(Result<Tags, String>),
    /// The saved views of the list, or why they cannot be used.
    Views(Result<SavedViews, String>),
    /// A frame is about to be drawn: what arrived takes its place.
    Drawing,
    /// A frame was drawn.
    Drawn,
    /// Models that servers on this machine serve.
    Discovered(Vec<Discovered>),
    /// The facts of a scenario, by its place in the list.
    Surveyed(usize, Result<Facts, String>),
    /// The most dangerous value of a measure in a scenario, by the measure's id and the place in the list.
    Ranked(&'static str, usize, Option<f64>),
    /// A scenario was opened.
    Opened(OpenId, Result<Box<Opened>, String>),
    /// A value of the open scene was computed.
    Computed(Computed),
    /// The user's thresholds were read, or why they cannot be used.
    Thresholds(Result<Arc<Thresholds>, String>),
    /// Earlier answers on the same thing.
    Stored(StoredOf, Vec<Answer>),
    /// Of the history of runs.
    History(runs::HistoryEvent),
    /// Of the screen of results.
    Results(runs::ResultsEvent),
    /// Of a job.
    Job(JobId, JobEvent),
    /// A planned ego was written: the files, or why not.
    DriveSaved(DriveKey, Result<String, String>),
    /// A variant was written: the files, or why not.
    VariantSaved(Arc<GeneratedVariant>, Result<String, String>),
    /// A rating of the answers of a round of the comparison was kept, under this number, or why not.
    Rated(u64, Result<i64, String>),
    /// Every rating, or why they cannot be read.
    Ratings(Result<Vec<Rating>, String>),
    /// What is left to rate.
    Unrated(Result<Unrated, String>),
    /// A template file was written or removed: its name, what to say, and the library as it is now.
    Saved(String, Result<(Library, String), String>),
    /// The templates were read again.
    Reread(Library),
    /// A file that says how the workbench looks was changed.
    Reloaded(Reloaded),
    /// A text was edited in the user's editor: which, and how it is now or why it is as before.
    EditedOutside(ExternalEdit, Result<String, String>),
    /// The source of a scenario was read: of which place in the list.
    Source(usize, Result<Box<Source>, String>),
    /// A picture was saved, and where; or why not.
    Pictured(Result<String, String>),
    /// A while has passed since something changed: the session is to be kept.
    KeepSession,
    /// A folder was looked through for experiment files.
    ExperimentFiles(PathBuf, Result<FolderOfExperiments, String>),
    /// Something went wrong outside.
    Complaint(String),
    /// The program is asked to end.
    Terminate,
    /// It is asked to stop for a while.
    Stop,
}

/// Contents of a reloaded file.
#[derive(Debug)]
pub enum Reloaded {
    /// The configuration, or why it cannot be used.
    Config(Result<Box<Config>, String>),
    /// The keymap, or what is wrong with its file.
    Keymap(Result<Keymap, String>),
    /// All themes.
    Themes(Vec<Named>),
}

/// The scenario, ego and task that stored answers are about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredOf {
    /// Hash of the scenario.
    pub scenario: String,
    /// Its name.
    pub name: String,
    /// The ego, as the store writes it.
    pub ego: String,
    /// Whether its motion is the recorded one, which recorded answers are about.
    pub recorded: bool,
    /// The task.
    pub task: Task,
}

/// Numbers the openings; a message of an old one is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct OpenId(pub u64);

/// Mouse events, with positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mouse {
    /// The left button went down.
    Press(Position),
    /// It moved with the left button down.
    Drag(Position),
    /// The left button went up.
    Release(Position),
    /// The wheel turned up.
    WheelUp(Position),
    /// The wheel turned down.
    WheelDown(Position),
}

/// A text for the user's own editor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExternalEdit {
    /// Name of its file.
    pub file: String,
    /// The text.
    pub text: String,
    /// Whether it is a read-only copy, whose changes are discarded.
    pub copy: bool,
    /// The user's own file, which is edited where it is; the text is what it held before.
    pub place: Option<PathBuf>,
}

/// An effect to be performed outside the model.
#[derive(Debug)]
pub enum Effect {
    /// Find the scenarios at these paths; the bundled ones for none.
    Find(Vec<PathBuf>),
    /// Look which model servers run on this machine.
    Probe,
    /// Work out the facts of these scenarios, by their places in the list, instead of those that were asked for before.
    Survey(Vec<(usize, Entry)>),
    /// Work out the facts of these too.
    SurveyMore(Vec<(usize, Entry)>),
    /// Of those that are waited for, take these first: they are on the screen.
    SurveyFirst(Vec<usize>),
    /// Read the store anew for the facts of these, by their places in the list.
    Recount(Vec<(usize, Entry)>),
    /// Read the user's tags.
    ReadTags,
    /// Give a scenario, by its name, these tags of the user's.
    ChangeTags(String, Vec<String>),
    /// Read the saved views of the list.
    ReadViews,
    /// Save a view of the list under a name, or delete it.
    ChangeView(String, Option<SavedView>),
    /// Work out the most dangerous value of a measure in these scenarios, by their places in the list.
    Rank(&'static str, Vec<(usize, Entry)>),
    /// Open a scenario, with an obstacle as ego or without one with its recorded or chosen ego.
    Open(OpenId, Entry, Option<i64>),
    /// The same, after a change of the scene.
    OpenChanged(OpenId, Entry, Option<i64>, Transform),
    /// Compute a value of the open scene.
    Compute(Computation),
    /// Read the user's thresholds again.
    ReadThresholds,
    /// Measure with these thresholds from now on.
    UseThresholds(Arc<Thresholds>),
    /// Load earlier answers.
    LoadStored(StoredOf),
    /// Keep a rating of the answers of a round of the comparison, in the place of the one with this number.
    Rate(u64, Box<NewRating>, Option<i64>),
    /// Read every rating.
    ReadRatings,
    /// Find out which answers to a task a person has not rated.
    FindUnrated(Task, String),
    /// Keep the draft of a template (its file and text) for the next start; nothing removes it.
    KeepDraft(String, Option<String>),
    /// Say [`Msg::KeepSession`] after a while.
    RememberLater,
    /// Keep what the workbench looks like for the next start.
    Remember(Box<super::session::Session>),
    /// Something for the history of runs.
    History(runs::HistoryCommand),
    /// Something for the screen of results.
    Results(runs::ResultsCommand),
    /// Start a job.
    Start(JobId, JobRequest),
    /// Cancel a job. A batch begins nothing more; cancelled once more, it ends what it began.
    Cancel(JobId),
    /// Write a planned ego.
    SaveDrive(Box<DriveFiles>),
    /// Write a variant into a folder; the current one if none is named.
    SaveVariant(Arc<GeneratedVariant>, Option<PathBuf>),
    /// Stop working out facts of scenarios.
    StopSurvey,
    /// Stop working out a measure of scenarios.
    StopRanking,
    /// Write a template of the user's.
    SaveTemplate(String, String),
    /// Take a template of the user's out of use, with the draft that was not saved.
    RemoveTemplate(String, Option<String>),
    /// Write a template of the user's under a new name, and use it for its task and frame.
    SaveTemplateAs(String, String),
    /// Use this template, of all those for its task and frame.
    UseTemplate(String),
    /// Let the user edit a text in an editor of theirs.
    EditOutside(ExternalEdit),
    /// Look through a folder for experiment files; an empty path is the working folder.
    ListExperiments(PathBuf),
    /// Read the source of a scenario, by its place in the list.
    ReadSource(usize, Entry),
    /// Read all templates again.
    RereadTemplates,
    /// Draw and save a picture.
    Picture(Box<PictureJob>),
    /// Put text into the clipboard.
    Copy(String),
    /// Use the mouse, or not.
    UseMouse(bool),
    /// Go back to the shell for a while.
    Suspend,
    /// End the program.
    Quit,
}
