//! Experiment files with real tasks: mistakes in them, and new ones from the marked scenarios.

use super::asking::Whole;
use super::asking::server::Server;
use super::experiments::{HEAD, counted, open, problem, toasts, write};
use crate::screens::experiment::ExperimentScreen;
use crate::screens::experiments::ExperimentsScreen;
use nearmiss_ask::prompts::Library;
use nearmiss_formats::EntryLocation;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_workflow::read_experiment;

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
        counted(&mut whole).await;
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
    counted(&mut whole).await;
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
    counted(&mut whole).await;
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
