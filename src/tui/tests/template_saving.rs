//! Edited texts: drafts, new names, the external editor, differences from the shipped template.

use std::time::Duration;

use super::bench::Bench;
use super::editing::{kept, said, with};
use crate::features::picker::PickerScreen;
use crate::features::prompt::request::{ChangeTemplate, TemplateChange};
use crate::features::prompt::saving::Templates;
use crate::message::{Effect, ExternalEdit, Msg};
use crate::model::{Pane, PromptView};
use nearmiss_ask::prompts::Library;
use nearmiss_settings::Keys;

#[test]
fn drafts_are_kept_within_a_second_of_typing() {
    let mut bench = with(Keys::Plain);
    bench.press("ctrl-g 1 0 enter");
    bench.type_text("Kept. ");
    assert!(kept(&bench).is_empty());
    for _ in 0..4 {
        assert!(bench.model.moves(), "time has to pass");
        bench.send(Msg::Passed(Duration::from_millis(250)));
    }
    let (file, text) = kept(&bench)[0];
    assert_eq!(file, "collision-ego.md");
    assert!(text.unwrap().contains("Kept. "));
    bench.effects.clear();
    bench.model.toasts.clear();
    assert!(!bench.model.moves(), "nothing is due any longer");
    // What is the same again needs no draft.
    bench.press("ctrl-z ctrl-z");
    bench.send(Msg::Passed(Duration::from_secs(1)));
    assert_eq!(kept(&bench), [("collision-ego.md", None)]);
    // A draft of a template that is not in the editor any longer is kept too.
    bench.effects.clear();
    bench.type_text("Again. ");
    bench.press("esc space a f");
    bench.effects.clear();
    bench.press("e x esc");
    let files: Vec<&str> = kept(&bench).into_iter().map(|(file, _)| file).collect();
    assert!(files.contains(&"collision-cartesian.md"), "{files:?}");
}

#[test]
fn a_template_is_saved_under_a_new_name_and_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = with(Keys::Plain);
    bench.press("ctrl-g 1 0 enter");
    bench.type_text("Brief. ");
    bench.press("ctrl-a");
    assert!(bench.frame(80, 24).contains("save as: collision-ego-▏"));
    bench.type_text("../x");
    bench.press("enter");
    assert!(said(&bench).contains("invalid template name"));
    bench.press("ctrl-a");
    bench.press(&"backspace ".repeat(14));
    bench.type_text("safety-ego");
    bench.press("enter");
    assert!(said(&bench).contains("safety-ego.md exists already"));
    bench.press("ctrl-a");
    bench.type_text("brief");
    bench.press("enter");
    let (file, text) = bench
        .effects
        .iter()
        .find_map(|e| match e.request() {
            Some(ChangeTemplate(file, TemplateChange::SaveAs(text))) => {
                Some((file.clone(), text.clone()))
            }
            _ => None,
        })
        .unwrap();
    assert_eq!(file, "collision-ego-brief.md");
    assert!(text.contains("name = \"collision-ego-brief\"") && text.contains("Brief. "));
    std::fs::write(folder.path().join(&file), &text).unwrap();
    nearmiss_ask::prompts::choose_template(folder.path(), "collision", "ego", &file).unwrap();
    bench.effects.clear();
    let library = Library::load(Some(folder.path()));
    bench.send(Msg::reply::<ChangeTemplate>((
        file.clone(),
        Ok((library, "saved".into())),
    )));
    assert_eq!(bench.model.prompt.file(), file);
    assert!(!bench.model.prompt.is_draft());
    assert!(kept(&bench).contains(&("collision-ego.md", None)));
    assert_eq!(bench.model.prompt.question.as_ref().unwrap().template, file);
    // The list shows both, and the shipped one as it was is chosen.
    bench.press("esc :");
    bench.type_text("choose among the templates");
    bench.press("enter");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("* collision-ego-brief.md") && frame.contains("  collision-ego.md"));
    assert!(bench.model.screens.is_top::<PickerScreen<Templates>>());
    bench.press("down enter");
    assert!(
        bench
            .effects
            .iter()
            .any(|e| matches!(e.request(), Some(ChangeTemplate(f, TemplateChange::Use)) if f == "collision-ego.md"))
    );
}

#[test]
fn the_users_editor_gets_the_template_and_what_comes_back_is_a_draft() {
    let mut bench = with(Keys::Plain);
    bench.press("ctrl-e");
    let sent = |bench: &mut Bench| match bench.effects.pop() {
        Some(Effect::EditOutside(outside)) => outside,
        other => panic!("{other:?}"),
    };
    let out = sent(&mut bench);
    assert_eq!((out.file.as_str(), out.copy), ("collision-ego.md", false));
    let before = out.text.clone();
    bench.send(Msg::EditedOutside(
        out.clone(),
        Err("`ed` cannot be started".into()),
    ));
    assert!(bench.model.prompt.text() == before && said(&bench).contains("cannot be started"));
    let new = before.replacen("You are", "You were", 1);
    bench.send(Msg::EditedOutside(
        out.clone(),
        Ok(new.replace('\n', "\r\n")),
    ));
    assert_eq!(bench.model.prompt.text(), new);
    assert!(
        bench
            .model
            .prompt
            .question
            .as_ref()
            .unwrap()
            .prompt
            .system
            .starts_with("You were")
    );
    bench.press("ctrl-z");
    assert_eq!(bench.model.prompt.text(), before);
    // Of the rendered prompt there is a copy.
    bench.press("esc");
    bench.model.focus = Pane::Prompt;
    bench.model.prompt.view = PromptView::Rendered;
    bench.press("ctrl-e");
    let copy = sent(&mut bench);
    assert!(copy.copy && copy.text.starts_with("You are an expert"));
    let changed = ExternalEdit {
        text: "x".into(),
        ..copy
    };
    bench.send(Msg::EditedOutside(changed, Ok("y".into())));
    assert!(said(&bench).contains("copy") && !bench.model.prompt.is_draft());
}

#[test]
fn the_difference_to_the_shipped_template_has_signs() {
    let mut bench = with(Keys::Plain);
    bench.press("ctrl-g 1 0 enter");
    bench.type_text("Mine. ");
    bench.press("esc space a v space a v");
    assert_eq!(bench.model.prompt.view, PromptView::Diff);
    bench.model.focus = Pane::Prompt;
    bench.model.zoomed = true;
    let frame = bench.frame(200, 60);
    assert!(
        frame.contains("+1 −1 lines vs shipped collision-ego.md"),
        "{frame}"
    );
    assert!(
        frame.contains("┃+Mine. You are") && frame.contains("┃-You are"),
        "{frame}"
    );
    assert!(frame.contains("unsaved drafts: collision-ego.md"));
}
