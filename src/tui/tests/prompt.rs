//! The prompt: switches, the editor, drafts that are right and drafts that are not.

use super::bench::Bench;
use crate::features::answers::Ask;
use crate::features::prompt::request::{
    ChangeTemplate, KeepDraft, RereadTemplates, TemplateChange,
};
use crate::features::scenarios::request::{Find, Found};
use crate::message::{Effect, Msg};
use crate::model::{Notice, PromptView};
use nearmiss_ask::prompts::Library;

fn rendered(bench: &Bench) -> String {
    let prompt = &bench.model.prompt.question.as_ref().unwrap().prompt;
    format!("{}\n{}", prompt.system, prompt.user)
}

#[test]
fn switches_change_the_prompt() {
    let mut bench = Bench::bundled();
    let all = rendered(&bench);
    assert!(
        all.contains("How to grade risk")
            && all.contains("Examples")
            && all.contains("step by step")
    );
    bench.press("space a c space a h space a i");
    let base = rendered(&bench);
    assert!(!base.contains("How to grade risk") && !base.contains("## Examples"));
    assert!(!base.contains("Work step by step"));
    bench.press("space a f");
    assert!(rendered(&bench).contains("coordinates of the map"));
    assert!(
        bench
            .frame(120, 40)
            .contains("collision · cartesian · base")
    );
}

#[test]
fn v_shows_template_and_description() {
    let mut bench = Bench::bundled();
    bench.press("space a v");
    assert_eq!(bench.model.prompt.view, PromptView::Template);
    assert!(bench.frame(120, 40).contains("name = \"collision-ego\""));
    bench.press("space a v");
    assert!(bench.frame(120, 40).contains("Sizes: the ego is"));
}

#[test]
fn the_prompt_follows_every_key_and_the_draft_is_what_is_asked() {
    let mut bench = Bench::bundled();
    bench.press("e");
    assert!(bench.frame(120, 40).contains("Ctrl-s save"));
    // Down to the first line of the system message.
    bench.press("ctrl-g 1 0 enter");
    bench.type_text("Dear model! ");
    assert!(
        rendered(&bench).starts_with("Dear model! You are an expert"),
        "{}",
        &rendered(&bench)[..60]
    );
    bench.press("esc r");
    assert!(bench.model.prompt.is_draft());
    let question = bench.effects.iter().find_map(|e| match e.request() {
        Some(Ask { question, .. }) => Some(question),
        _ => None,
    });
    assert!(question.unwrap().prompt.system.starts_with("Dear model!"));
}

#[test]
fn a_broken_template_is_named_and_the_last_good_one_stays() {
    let mut bench = Bench::bundled();
    let before = rendered(&bench);
    bench.press("e ctrl-g 1 0 enter");
    bench.type_text("{{ oops ");
    let error = bench.model.prompt.error.clone().unwrap();
    assert!(error.contains("collision-ego.md:10"), "{error}");
    // The first brace alone could still be filled.
    assert!(rendered(&bench) == format!("{{{before}"));
    assert!(bench.frame(120, 40).contains("rendered, last good"));
    bench.press("ctrl-s");
    assert!(bench.effects.iter().all(|e| !matches!(
        e.request(),
        Some(ChangeTemplate(_, TemplateChange::Save(_)))
    )));
    bench.model.model = "lab/small".into();
    bench.press("esc g tab r");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("requests disabled until fixed"), "{frame}");
    assert!(
        frame.contains("{{ oops"),
        "the place of the error is shown: {frame}"
    );
    assert_eq!(bench.model.focus, crate::model::Pane::Prompt);
    assert_eq!(
        bench.model.prompt.editor.cursor().0 + 1,
        bench.model.prompt.error_line.unwrap()
    );
    assert!(
        bench
            .effects
            .iter()
            .all(|e| !matches!(e.request(), Some(Ask { .. }))),
        "a broken template is not sent"
    );
    assert_eq!(bench.model.toasts.last().unwrap().kind, Notice::Error);
}

#[test]
fn saving_writes_the_users_copy_and_reset_removes_it() {
    let mut bench = Bench::bundled();
    bench.press("e ctrl-g 1 0 enter");
    bench.type_text("Mine. ");
    bench.press("ctrl-s");
    let saved = bench.effects.iter().find_map(|e| match e.request() {
        Some(ChangeTemplate(file, TemplateChange::Save(text))) => {
            Some((file.clone(), text.clone()))
        }
        _ => None,
    });
    let (file, text) = saved.unwrap();
    assert!(file == "collision-ego.md" && text.contains("Mine. You are an expert"));

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(&file), &text).unwrap();
    bench.send(Msg::reply::<ChangeTemplate>((
        file,
        Ok((Library::load(Some(folder.path())), "saved".into())),
    )));
    assert!(!bench.model.prompt.is_draft());
    bench.press("esc :");
    bench.type_text("discard-draft");
    bench.press("enter");
    assert!(bench.effects.iter().any(|e| matches!(
        e.request(),
        Some(ChangeTemplate(_, TemplateChange::Remove(_)))
    )));
    bench.send(Msg::reply::<ChangeTemplate>((
        "collision-ego.md".into(),
        Ok((Library::load(None), "shipped".into())),
    )));
    assert!(!rendered(&bench).contains("Mine."));
}

#[test]
fn drafts_of_other_templates_are_kept() {
    let mut bench = Bench::bundled();
    bench.press("e ctrl-g 1 0 enter");
    bench.type_text("Draft. ");
    bench.press("esc space a f");
    assert!(!rendered(&bench).contains("Draft."));
    // Round all the frames that the task has a template for.
    bench.press("space a f");
    assert!(rendered(&bench).contains("described by safety measures"));
    bench.press("space a f");
    assert!(rendered(&bench).contains("The picture shows the scene"));
    // The words with the picture beside them have the templates of the words.
    bench.press("space a f");
    assert!(rendered(&bench).contains("Draft."));
    bench.press("space a f space a f space a f");
    assert!(rendered(&bench).contains("Draft."));
}

#[test]
fn pasted_text_goes_into_the_editor_at_once() {
    let mut bench = Bench::bundled();
    bench.press("e ctrl-g 1 0 enter");
    bench.send(Msg::Paste("two\r\nlines ".into()));
    assert!(bench.model.prompt.text().contains("two\nlines"));
}

#[test]
fn a_draft_is_kept_for_the_next_start_and_taken_up() {
    let mut bench = Bench::bundled();
    bench.press("e ctrl-g 1 0 enter");
    bench.type_text("Kept. ");
    bench.press("esc q");
    let kept = bench.effects.iter().rev().find_map(|e| match e.request() {
        Some(KeepDraft(file, Some(text))) => Some((file.clone(), text.clone())),
        _ => None,
    });
    let (file, text) = kept.unwrap();
    assert!(matches!(bench.effects.last(), Some(Effect::Quit)));
    let mut bench = Bench::empty();
    bench.model.prompt.take_up(file, text);
    bench.send(Msg::reply::<Find>(Found::All(Ok(
        nearmiss_formats::bundled().into(),
    ))));
    assert!(rendered(&bench).starts_with("Kept. You are"));
}

#[test]
fn broken_front_matter_is_named_and_the_built_in_judge_does_not_care() {
    let mut bench = Bench::bundled();
    bench.press("e x esc");
    assert!(bench.model.prompt.error.as_ref().unwrap().contains("+++"));
    assert!(bench.model.prompt.question.is_some());
    bench.press("r");
    assert!(
        bench
            .effects
            .iter()
            .any(|e| matches!(e.request(), Some(Ask { .. })))
    );
}

#[test]
fn a_users_file_that_breaks_while_the_program_runs_stays_in_use_as_it_was() {
    let mut bench = Bench::bundled();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("collision-ego.md");
    let mine = Library::shipped("collision-ego.md")
        .unwrap()
        .replace("You are an expert", "You are mine");
    std::fs::write(&file, mine).unwrap();
    bench.press(":");
    bench.type_text("reread-templates");
    bench.press("enter");
    assert!(
        bench
            .effects
            .iter()
            .any(|e| matches!(e.request(), Some(RereadTemplates)))
    );
    bench.send(Msg::reply::<RereadTemplates>(Library::load(Some(
        folder.path(),
    ))));
    assert!(rendered(&bench).contains("You are mine"));
    std::fs::write(&file, "+++\nname = 7\n+++\n").unwrap();
    bench.send(Msg::reply::<RereadTemplates>(Library::load(Some(
        folder.path(),
    ))));
    assert!(rendered(&bench).contains("You are mine"));
    let said = |bench: &Bench| {
        let bad = bench
            .model
            .toasts
            .iter()
            .filter(|t| t.kind == crate::model::Notice::Error);
        bad.map(|t| t.text.clone()).collect::<Vec<_>>().join("\n")
    };
    assert!(
        said(&bench).contains("collision-ego.md: line 2") && said(&bench).contains("last good"),
        "{}",
        said(&bench)
    );
    std::fs::remove_file(&file).unwrap();
    bench.send(Msg::reply::<RereadTemplates>(Library::load(Some(
        folder.path(),
    ))));
    assert!(rendered(&bench).contains("You are an expert"));
}

#[test]
fn techniques_are_the_templates_until_they_are_chosen() {
    let mut bench = Bench::bundled();
    let folder = tempfile::tempdir().unwrap();
    let mine = Library::shipped("collision-ego.md").unwrap().replacen(
        "+++\n{%",
        "\n[defaults]\ntechniques = \"cot\"\nhistory = 3\n+++\n{%",
        1,
    );
    std::fs::write(folder.path().join("collision-ego.md"), mine).unwrap();
    bench.send(Msg::reply::<RereadTemplates>(Library::load(Some(
        folder.path(),
    ))));
    assert_eq!(bench.model.techniques.to_string(), "cot");
    assert_eq!(rendered(&bench).matches(",ego,").count(), 3);
    bench.press("space a c");
    assert_eq!(bench.model.techniques.to_string(), "cp+cot");
    bench.press("space a f");
    assert_eq!(bench.model.techniques.to_string(), "cp+cot");
}
