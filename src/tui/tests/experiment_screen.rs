//! The screen of an experiment, and its files.

use std::path::{Path, PathBuf};

use crate::action::{ACTIONS, Action, Scope};
use crate::features::batch::request::{AskBatch, BatchProgress, ItemChange};
use crate::features::experiment::ExperimentScreen;
use crate::features::experiment::list::ExperimentsScreen;
use crate::features::experiment::request::{
    AskExperiment, ExperimentNews, ListExperiments, ReadExperiment,
};
use crate::message::{Effect, Msg};
use crate::model::{CountedExperiment, ExperimentOutline, JobId, Update};
use crate::session::{Session, restore};
use crate::tests::asking::Whole;
use crate::tests::asking::server::Server;
use crate::tests::bench::Bench;
use crate::tests::everywhere::seen_in_every_theme;
use crate::tests::experiments::{self, HEAD, open, problem, toasts, write};
use nearmiss_ask::prompts::Library;
use nearmiss_formats::EntryLocation;
use nearmiss_store::{BatchId, ItemState};
use nearmiss_study::evaluation::PromptConfig;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_workflow::batch::DryRunLine;
use nearmiss_workflow::{
    ConfigurationProgress, ExperimentAxis, ExperimentFile, ExperimentProgress, FolderOfExperiments,
    read_experiment,
};

const SIZES: [(u16, u16); 5] = [(60, 18), (80, 24), (100, 30), (120, 40), (200, 60)];

fn way(techniques: &str, effort: &str) -> PromptConfig {
    let effort = nearmiss_ask::llm::Effort::parse(effort);
    PromptConfig {
        task: nearmiss_scene::verdict::Task::Safety,
        frame: Some(nearmiss_scene::description::Frame::Ego),
        techniques: Some(nearmiss_ask::prompts::Techniques::parse(techniques).unwrap()),
        model: "lab/small".into(),
        settings: nearmiss_study::evaluation::AxisValues {
            effort,
            ..Default::default()
        },
        template: None,
    }
}

pub(super) fn outline() -> ExperimentOutline {
    let axis = |name, values: &[&str]| ExperimentAxis {
        name,
        values: values.iter().map(ToString::to_string).collect(),
    };
    ExperimentOutline {
        title: Some("Does contextual prompting help?".into()),
        axes: vec![
            axis("models", &["lab/small", "lab/large"]),
            axis("techniques", &["base", "all"]),
            axis("leads", &[]),
        ],
        ways: 4,
        facts: vec![("scenarios", "ZAM_CutIn-1_1_T-1".into())],
        is_split: true,
    }
}

pub(super) fn counted(batch: Option<BatchId>) -> CountedExperiment {
    let of_way = |techniques, answered, failed, open| ConfigurationProgress {
        configuration: way(techniques, "low"),
        answered,
        failed,
        open,
        unaskable: 0,
    };
    CountedExperiment {
        batch,
        progress: ExperimentProgress {
            configurations: vec![of_way("base", 3, 1, 8), of_way("all", 0, 0, 12)],
            scenarios: 4,
            windows: 12,
        },
        lines: vec![
            DryRunLine::Value("requests", "21".into()),
            DryRunLine::Value("price", "at most $0.0420".into()),
            DryRunLine::Note("(tokens at the highest price)"),
        ],
        requests: 21,
        price: "at most $0.0420".into(),
        split: Some((2, 2)),
        test: vec!["test split: 1 of 12 answered, locked".into()],
        reasons: vec![("the model is tired".into(), 1)],
        spent: (0.0123, 1),
        ..CountedExperiment::default()
    }
}

/// The number of the last reading that was asked for.
fn reading(bench: &Bench) -> JobId {
    let mut effects = bench.effects.iter().rev();
    effects
        .find_map(|effect| match effect.request() {
            Some(ReadExperiment { id, .. }) => Some(*id),
            _ => None,
        })
        .expect("the file is read")
}

fn tell(bench: &mut Bench, update: Update<ExperimentNews, Box<CountedExperiment>>) {
    let id = reading(bench);
    bench.send(Msg::reply::<ReadExperiment>((id, update)));
}

/// A workbench with an experiment that has been read.
fn opened(batch: Option<BatchId>) -> Bench {
    let mut bench = Bench::bundled();
    bench.model.recall.here = PathBuf::from("/labs");
    bench.model.experiment.chosen = Some("study.toml".into());
    bench.press("space o e");
    let text = "title = \"Does contextual prompting help?\"\nmodels = []\n".to_string();
    let read = Box::new((text, Some(outline())));
    tell(&mut bench, Update::Progress(ExperimentNews::Read(read)));
    tell(&mut bench, Update::Ended(Ok(Box::new(counted(batch)))));
    bench
}

#[test]
fn one_of_a_kind_is_said_in_the_singular() {
    let mut bench = opened(None);
    let mut one = counted(None);
    (one.progress.scenarios, one.progress.windows) = (1, 1);
    one.progress.configurations.truncate(1);
    tell(&mut bench, Update::Ended(Ok(Box::new(one))));
    let frame = bench.frame(200, 60);
    assert!(
        frame.contains("1 scenario · 1 window · 1 way of asking "),
        "{frame}"
    );
}

#[test]
fn everything_is_seen_at_every_size() {
    for size in SIZES {
        let mut bench = opened(Some(BatchId(3)));
        bench.model.size = size;
        let words = seen_in_every_theme("experiment", &mut bench, size, false);
        assert!(
            words.contains("study.toml") && words.contains("b3"),
            "{words}"
        );
        let last = words.lines().last().unwrap();
        assert!(
            last.contains("r run") && last.contains("Esc close"),
            "{last}"
        );
        // All of it, a line at a time.
        let mut all = words;
        for _ in 0..60 {
            bench.press("down");
            all += &bench.frame(size.0, size.1);
        }
        for words in [
            "Does contextual prompting help?",
            "21",
            "at most $0.0420",
            "$0.0123",
            "test split: 1 of 12",
            "ego · base",
            "lab/large",
            "default",
        ] {
            assert!(all.contains(words), "{words} at {size:?}: {all}");
        }
        bench.press("r");
        let words = seen_in_every_theme("confirmation", &mut bench, size, false);
        assert!(
            words.contains("at most $0.0420") && words.contains("goes on with b3"),
            "{words}"
        );
        bench.press("n t");
        let words = seen_in_every_theme("text", &mut bench, size, false);
        assert!(words.contains("1 title = "), "{words}");
    }
}

#[test]
fn frames_at_two_sizes() {
    for (columns, rows) in [(60, 18), (80, 24)] {
        let bench = opened(Some(BatchId(3)));
        let frame = bench.frame(columns, rows);
        insta::assert_snapshot!(format!("experiment_at_{columns}_by_{rows}"), frame);
    }
    let mut bench = opened(None);
    bench.press("r");
    insta::assert_snapshot!("experiment_confirmed_at_80_by_24", bench.frame(80, 24));
}

#[test]
fn progress_is_followed_by_way_of_asking() {
    let mut bench = opened(None);
    bench.press("r y");
    let asked = bench
        .effects
        .iter()
        .find_map(|effect| match effect.request() {
            Some(AskExperiment { id, questions, .. }) => Some((*id, *questions)),
            _ => None,
        });
    let (id, questions) = asked.expect("it is asked");
    assert_eq!(questions, 21);
    let change = |techniques| ItemChange {
        way: way(techniques, "low"),
        before: ItemState::Waiting,
        now: ItemState::Answered,
    };
    for techniques in ["base", "base", "all"] {
        let changed = BatchProgress::Changed(Box::new(change(techniques)));
        bench.send(Msg::reply::<AskBatch>((id, Update::Progress(changed))));
    }
    let ways = &bench.model.experiment.progress.configurations;
    let counts: Vec<_> = ways.iter().map(|way| (way.answered, way.open)).collect();
    assert_eq!(counts, [(5, 6), (1, 11)]);
    assert!(bench.frame(80, 24).contains("running"));
    // Esc leaves it running; x stops it.
    bench.press("esc");
    assert!(bench.model.screens.is_empty() && bench.model.experiment.asking == Some(id));
    bench.model.experiment.chosen = Some("/labs/study.toml".into());
    bench.press("space o e x");
    let stopped = bench
        .effects
        .iter()
        .any(|e| matches!(e, Effect::Cancel(job) if *job == id));
    assert!(stopped);
    assert!(bench.frame(80, 24).contains("stopping"));
}

#[test]
fn every_key_of_the_screen_is_bound_and_in_help() {
    let mut bench = opened(Some(BatchId(3)));
    let actions: Vec<_> = ACTIONS
        .iter()
        .filter(|e| e.scope == Scope::Experiment)
        .collect();
    assert!(actions.len() > 10);
    for entry in actions {
        assert!(
            bench.model.look.keymap.keys(entry).next().is_some(),
            "{}",
            entry.id
        );
    }
    bench.press("?");
    let help = bench.frame(120, 60);
    assert!(help.contains("on the screen of an experiment"), "{help}");
    for id in ["experiment", "new-experiment"] {
        let mut bench = Bench::bundled();
        bench.perform(id);
        assert!(bench.model.screens.is_top::<ExperimentsScreen>(), "{id}");
    }
    assert!(
        ACTIONS
            .iter()
            .any(|entry| entry.action == Action::NewExperiment)
    );
}

#[test]
fn the_file_goes_to_the_editor_where_it_is_and_is_read_again() {
    let mut bench = opened(None);
    bench.effects.clear();
    bench.press("e");
    let sent = bench
        .effects
        .drain(..)
        .find_map(|effect| match effect {
            Effect::EditOutside(sent) => Some(sent),
            _ => None,
        })
        .unwrap();
    assert_eq!(sent.place.as_deref(), Some(Path::new("/labs/study.toml")));
    bench.send(Msg::EditedOutside(sent.clone(), Ok("models = 3".into())));
    tell(
        &mut bench,
        Update::Ended(Err("/labs/study.toml:1: wrong".into())),
    );
    assert_eq!(
        bench.model.experiment.problem.as_deref(),
        Some("study.toml:1: wrong")
    );
    // Without an editor the text is shown, with the reason.
    bench.send(Msg::EditedOutside(
        sent,
        Err("neither VISUAL nor EDITOR is set".into()),
    ));
    assert!(bench.model.experiment.shows_text);
    assert!(bench.frame(120, 40).contains("neither VISUAL nor EDITOR"));
}

fn listing() -> FolderOfExperiments {
    let file = |path: &str, title: Option<&str>| ExperimentFile {
        path: path.into(),
        title: title.map(Into::into),
    };
    FolderOfExperiments {
        files: vec![file("a.toml", Some("A?")), file("leads.toml", None)],
        folders: vec!["more".into()],
    }
}

#[test]
fn the_chooser_lists_completes_and_opens() {
    let mut bench = Bench::bundled();
    bench.model.recall.here = PathBuf::from("/labs");
    bench.model.experiment.recent = vec!["/elsewhere/old.toml".into()];
    bench.press("space o e");
    let asks = |bench: &Bench, wanted: &str| {
        bench.effects.iter().any(
            |e| matches!(e.request(), Some(ListExperiments(folder)) if folder == Path::new(wanted)),
        )
    };
    assert!(asks(&bench, ""));
    bench.send(Msg::reply::<ListExperiments>((
        PathBuf::new(),
        Ok(listing()),
    )));
    for size in SIZES {
        bench.model.size = size;
        let words = seen_in_every_theme("chooser", &mut bench, size, true);
        for row in [
            "/elsewhere/old.toml",
            "a.toml",
            "leads.toml",
            "new from the marked",
        ] {
            assert!(words.contains(row), "{row}: {words}");
        }
    }
    // A path is completed, folder by folder.
    bench.type_text("more/");
    assert!(asks(&bench, "more/"));
    let below = FolderOfExperiments {
        files: vec![ExperimentFile {
            path: "more/b.toml".into(),
            title: None,
        }],
        folders: vec!["more/deep".into()],
    };
    bench.send(Msg::reply::<ListExperiments>(("more/".into(), Ok(below))));
    bench.type_text("d");
    bench.press("tab");
    assert!(asks(&bench, "more/deep/"));
    for _ in 0.."deep/".len() {
        bench.press("backspace");
    }
    let again = FolderOfExperiments {
        files: vec![ExperimentFile {
            path: "more/b.toml".into(),
            title: None,
        }],
        folders: Vec::new(),
    };
    bench.send(Msg::reply::<ListExperiments>(("more/".into(), Ok(again))));
    bench.press("tab enter");
    assert!(bench.model.screens.is_top::<ExperimentScreen>());
    assert_eq!(
        bench.model.experiment.file,
        Some("/labs/more/b.toml".into())
    );
    // A folder that cannot be read is said in its place.
    bench.press("esc space o e");
    bench.type_text("x/");
    bench.send(Msg::reply::<ListExperiments>((
        "x/".into(),
        Err("x/: No such file".into()),
    )));
    assert!(bench.frame(80, 24).contains("x/: No such file"));
}

#[test]
fn a_session_remembers_experiments_and_older_ones_still_load() {
    let mut bench = opened(None);
    let session = restore::capture(&bench.model);
    assert_eq!(session.experiments, [PathBuf::from("/labs/study.toml")]);
    let text = session.text().unwrap();
    let read = Session::parse(&text, &session.paths).unwrap();
    let mut again = Bench::empty();
    restore::restore(&mut again.model, read, false);
    assert_eq!(again.model.experiment.recent, session.experiments);
    // One that an earlier version wrote has no such list.
    bench.model.experiment.recent.clear();
    let old = restore::capture(&bench.model).text().unwrap();
    assert!(!old.contains("experiments"), "{old}");
    assert!(
        Session::parse(&old, &session.paths)
            .unwrap()
            .experiments
            .is_empty()
    );
    for i in 0..20 {
        let file = PathBuf::from(format!("/labs/{i}.toml"));
        bench.model.experiment.remember(&file);
    }
    let recent = &bench.model.experiment.recent;
    assert_eq!(
        (recent.len(), recent[0].as_path()),
        (10, Path::new("/labs/19.toml"))
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_wrong_is_said_where_it_is_and_mended() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(Vec::new()).await;
    let mut whole = Whole::start(
        &server,
        "[provider.paid]\nbase_url = \"http://127.0.0.1:9/v1\"\nkey_env = [\"NO_SUCH_KEY_HERE\"]\n",
    );
    // The file is gone.
    open(&mut whole, &folder.path().join("none.toml")).await;
    assert!(
        problem(&whole).contains("none.toml: "),
        "{}",
        problem(&whole)
    );
    assert!(whole.model.experiment.recent.is_empty());
    whole.press("r enter");
    assert!(!whole.model.experiment.confirming && whole.model.screens.is_top::<ExperimentScreen>());
    // Mistakes, with line and key.
    let wrong = format!("{HEAD}models = [\"lab/small\"]\nsample = 3\nwithin = 11\n");
    let file = write(folder.path(), "e.toml", &wrong);
    open(&mut whole, &file).await;
    for words in [
        "e.toml:3: unknown key `sample`; did you mean `samples`?",
        "e.toml:4: within = 11: expected a number above 0, at most 10",
    ] {
        assert!(problem(&whole).contains(words), "{}", problem(&whole));
    }
    assert_eq!(
        whole.model.experiment.text.as_deref(),
        Some(&*wrong),
        "its text is shown"
    );
    // Scenarios that are not there, and others than it was written with.
    for (text, words) in [
        (
            "scenarios = [\"nowhere\"]\nmodels = [\"lab/small\"]\n".to_string(),
            "nowhere",
        ),
        (
            format!(
                "{HEAD}models = [\"lab/small\"]\n[hashes]\n\"ZAM_CutIn-1_1_T-1\" = \"000000000000\"\n"
            ),
            "was written with 000000000000; use that file, or remove its hash",
        ),
        (format!("{HEAD}models = [\"no/model\"]\n"), "no"),
    ] {
        write(folder.path(), "e.toml", &text);
        whole.press("shift-r");
        experiments::counted(&mut whole).await;
        assert!(problem(&whole).contains(words), "{}", problem(&whole));
        whole.press("r");
        assert!(!whole.model.experiment.confirming);
    }
    // A model without its key is told before anything is asked.
    write(
        folder.path(),
        "e.toml",
        &format!("{HEAD}models = [\"paid/x\"]\n"),
    );
    whole.press("shift-r");
    experiments::counted(&mut whole).await;
    let refused = &whole.model.experiment.counted.as_ref().unwrap().refused;
    assert!(refused[0].1.contains("NO_SUCH_KEY_HERE"), "{refused:?}");
    whole.press("r");
    assert!(!whole.model.experiment.confirming);
    assert!(toasts(&whole.model).contains("NO_SUCH_KEY_HERE"));
    assert_eq!(whole.model.experiment.recent, [file]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_new_one_is_what_the_workbench_asks_and_replaces_nothing_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(Vec::new()).await;
    let mut whole = Whole::start(&server, "temperature = 0.5");
    whole
        .until("scenarios", |model| {
            model.list.found && model.opened.is_some()
        })
        .await;
    whole.press("* down *");
    whole.model.recall.here = folder.path().to_path_buf();
    whole.press("space a t space a n");
    assert!(whole.model.screens.is_top::<ExperimentsScreen>());
    whole.press("enter");
    experiments::counted(&mut whole).await;
    let file = folder.path().join("experiment.toml");
    assert_eq!(whole.model.experiment.file.as_ref(), Some(&file));
    assert_eq!(problem(&whole), "");
    let text = std::fs::read_to_string(&file).unwrap();
    let library = Library::load(None);
    let read = read_experiment(&text, &file, &library).unwrap();
    let model = &whole.model;
    let matrix = &read;
    assert_eq!(
        (&matrix.models, &matrix.tasks),
        (&vec![model.model.clone()], &vec![model.task])
    );
    assert_eq!(
        (&matrix.frames, &matrix.techniques),
        (&vec![model.frame], &vec![model.decided().techniques])
    );
    assert_eq!(matrix.temperature.one(), Some(0.5));
    assert_eq!(
        (
            read.scenarios.len(),
            read.hashes.len(),
            read.templates.len()
        ),
        (2, 2, 1)
    );
    // The second time it asks first.
    std::fs::write(&file, "mine").unwrap();
    whole.press("esc space a n enter");
    whole
        .until("an answer", |model| model.experiment.exists.is_some())
        .await;
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    whole.press("esc");
    assert!(whole.model.experiment.exists.is_none());
    assert!(whole.model.screens.is_top::<ExperimentsScreen>());
    whole.press("enter");
    whole
        .until("an answer", |model| model.experiment.exists.is_some())
        .await;
    whole.press("enter");
    whole
        .until("the file", |model| {
            model.screens.is_top::<ExperimentScreen>()
        })
        .await;
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    // The same as the function of the command line gives.
    let entries = whole.model.marks.chosen(&whole.model.list);
    assert!(
        entries
            .iter()
            .all(|entry| matches!(entry.place, EntryLocation::Bundled(_)))
    );
    assert_eq!((&read.select, &read.split), (&None, &None));
    let stored = Spec::templates_for(matrix, &library);
    assert!(
        read.templates
            .iter()
            .all(|pin| stored[&pin.name].starts_with(&pin.hash))
    );
    // What a file cannot say is not written.
    whole.press("esc");
    whole.model.frame = nearmiss_scene::description::Frame::Trajectory;
    whole.press("space a n o enter");
    assert!(toasts(&whole.model).contains("needs one picked obstacle"));
    assert!(!folder.path().join("experiment.tomlo.toml").exists());
}
