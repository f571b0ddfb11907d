//! The prompt, its templates saved and chosen, and tools for models.

use std::time::Duration;

use crate::features::answers::Ask;
use crate::features::batch::request::EstimateBatch;
use crate::features::picker::PickerScreen;
use crate::features::prompt::request::{
    ChangeTemplate, KeepDraft, RereadTemplates, TemplateChange,
};
use crate::features::prompt::saving::Templates;
use crate::features::scenarios::request::{Find, Found};
use crate::message::{Effect, ExternalEdit, Msg};
use crate::model::{Notice, Pane, Prices, PromptView, RequestTokens};
use crate::session::{Session, restore};
use crate::tests::bench::{self, Bench, answer};
use crate::tests::editing::{kept, said, with};
use nearmiss_ask::llm::{Environment, Registry, ToolLimits};
use nearmiss_ask::prompts::Library;
use nearmiss_settings::Keys;
use nearmiss_study::evaluation::Answer;

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
    bench.model.model = "lab/small".into();
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
    assert!(rendered(&bench) == before, "no brace of what is half typed");
    assert!(bench.frame(120, 40).contains("rendered, last good"));
    bench.press("ctrl-s");
    assert!(bench.effects.iter().all(|e| !matches!(
        e.request(),
        Some(ChangeTemplate(_, TemplateChange::Save { .. }))
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
        Some(ChangeTemplate(file, TemplateChange::Save { text, .. })) => {
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
        Some(KeepDraft {
            file,
            draft: Some(text),
            ..
        }) => Some((file.clone(), text.clone())),
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
    bench.press("e ctrl-home x esc");
    assert!(bench.model.prompt.error.as_ref().unwrap().contains("+++"));
    assert!(bench.model.prompt.question.is_some());
    bench.press("r");
    // It reads no prompt: models are offered for the draft.
    let frame = bench.frame(120, 40);
    assert!(frame.contains("reads no prompt"), "{frame}");
    assert!(!bench.model.screens.is_empty());
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
fn where_the_pane_has_no_room_its_key_shows_it_first() {
    let mut bench = Bench::bundled();
    bench.send(Msg::Resize(80, 24));
    assert_ne!(bench.model.focus, Pane::Prompt);
    bench.press("space a v");
    assert_eq!(bench.model.focus, Pane::Prompt);
    assert_eq!(bench.model.prompt.view, PromptView::Rendered);
    bench.press("space a v");
    assert_eq!(bench.model.prompt.view, PromptView::Template);
}

#[test]
fn the_header_says_that_a_draft_is_used() {
    let mut bench = with(Keys::Plain);
    bench.type_text("Mine. ");
    bench.press("esc");
    for (columns, rows) in [(80, 24), (200, 60)] {
        let frame = bench.frame(columns, rows);
        assert!(
            frame.lines().next().unwrap().contains(" · draft"),
            "{frame}"
        );
    }
    bench.press("e ctrl-z esc");
    assert!(!bench.frame(80, 24).contains("draft"));
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

#[test]
fn what_was_edited_is_in_sight_afterwards_and_the_first_change_in_the_difference() {
    let mut bench = with(Keys::Plain);
    bench.press("ctrl-end");
    let (line, _) = bench.model.prompt.editor.cursor();
    bench.type_text("The last words. ");
    bench.press("esc");
    bench.model.focus = Pane::Prompt;
    bench.model.zoomed = true;
    assert!(line > 24, "it is below the first screen");
    let frame = bench.frame(80, 24);
    assert!(frame.contains("The last words."), "{frame}");
    bench.press("space a v space a v");
    let frame = bench.frame(80, 24);
    let place = |words: &str| frame.lines().position(|line| line.contains(words));
    let first = place("vs shipped").zip(place("@@ -"));
    assert!(
        first.is_some_and(|(head, hunk)| hunk == head + 1),
        "{frame}"
    );
}

/// A workbench that asks a model with a price.
fn asking() -> Bench {
    let mut bench = Bench::bundled();
    let lab = "[lab]\nbase_url = \"http://lab.example\"\n[[lab.prices]]\nmodel = \"small\"\ninput = 1.0\noutput = 2.0\n";
    let registry = Registry::new(&toml::from_str(lab).unwrap()).unwrap();
    let free = registry.free(&Environment::from_lookup(|_| None));
    bench.model.prompt.prices = Prices::new(registry, free, jiff::civil::date(2026, 1, 1));
    bench.model.config.max_tokens = Some(200);
    bench.model.model = "lab/small".into();
    bench
}

fn last_tools(bench: &Bench) -> Option<ToolLimits> {
    let mut all = bench.effects.iter().rev();
    let found = all.find_map(|effect| {
        let asked = effect.request().map(|ask: &Ask| ask.tools);
        let estimated = effect.request();
        asked.or_else(|| estimated.map(|of: &EstimateBatch| of.batch.experiment.parameters().tools))
    });
    found.expect("something was asked")
}

#[test]
fn the_key_switches_what_is_asked_with_and_what_the_header_says() {
    let mut bench = asking();
    bench.press("r");
    assert_eq!(last_tools(&bench), None);
    assert!(!bench.frame(200, 60).contains("+tools"));
    bench.press("space a");
    assert!(bench.frame(200, 60).contains("tools for models on/off"));
    bench.press("u");
    let frame = bench.frame(200, 60);
    assert!(frame.contains("ego · cp+cot+icl+tools"), "{frame}");
    assert!(frame.contains("lab/small may call tools: at most $"));
    assert!(bench.frame(80, 24).contains("collision+tools · lab/small"));
    bench.press("r");
    assert_eq!(last_tools(&bench), Some(ToolLimits::default()));
    let column = bench.model.answers.column().unwrap();
    assert_eq!(column.how, "ego · cp+cot+icl+tools");
    bench.press("space a a");
    assert_eq!(last_tools(&bench), Some(ToolLimits::default()));
    let card = bench.frame(120, 40);
    for words in ["cp+cot+icl+tools", "each with up to 8 rounds of tools"] {
        assert!(card.contains(words), "{card}");
    }
    bench.press("esc space a u space a a");
    assert_eq!(last_tools(&bench), None);
}

#[test]
fn what_calls_no_tools_is_asked_without() {
    let mut bench = asking();
    for model in ["reference/geometry", "recorded/gpt-4o"] {
        bench.model.model = model.into();
        bench.model.tools = false;
        bench.press("space a u");
        let frame = bench.frame(200, 60);
        let words = format!("tools on, but not for {model}; m chooses a model");
        assert!(frame.contains(&words), "{frame}");
        bench.press("r");
        assert_eq!(last_tools(&bench), None, "{model}");
    }
}

#[test]
fn the_price_is_that_of_all_rounds() {
    let mut bench = asking();
    let alone = bench.model.price();
    let tokens = bench.model.prompt.tokens;
    bench.press("space a u");
    let with_tools = bench.model.price();
    let usd = |words: &str| words.strip_prefix("at most $").unwrap().parse::<f64>();
    let (alone, with_tools) = (usd(&alone).unwrap(), usd(&with_tools).unwrap());
    // Nine requests, each with the question and the tools.
    assert!(with_tools > 9.0 * alone, "{with_tools} {alone}");
    let nine = [RequestTokens {
        question: tokens,
        answer: Some(200),
    }; 9];
    let bare = bench.model.prompt.prices.of_requests("lab/small", &nine);
    assert!(with_tools > usd(&bare).unwrap());
    let narrow = bench.frame(80, 24);
    assert!(
        narrow.contains("collision+tools · lab/small · ≤$"),
        "{narrow}"
    );
    bench.press("m");
    let words = format!("at most ${with_tools:.4}");
    assert!(bench.frame(120, 40).contains(&words), "as in the list");
}

#[test]
fn the_answer_of_the_way_that_is_switched_to_is_shown() {
    let mut bench = asking();
    for (keys, how) in [
        ("r", "ego · cp+cot+icl"),
        ("space a u r", "ego · cp+cot+icl+tools"),
    ] {
        bench.press(keys);
        let (id, model) = bench.asked();
        let said = Answer {
            how: how.into(),
            ..answer(&model, true, 301)
        };
        bench.send(bench::answered(id, Ok(Box::new(said))));
    }
    let shown = |bench: &Bench| bench.model.answers.column().unwrap().how.clone();
    assert_eq!(shown(&bench), "ego · cp+cot+icl+tools");
    let frame = bench.frame(200, 60);
    let beside = frame.matches("icl+tools").count();
    assert!(beside > 1, "in the header, and they differ: {frame}");
    let narrow = bench.frame(80, 24);
    assert!(narrow.contains(" all+t "), "in less room: {narrow}");
    bench.press("space a u");
    assert_eq!(shown(&bench), "ego · cp+cot+icl");
    bench.press("space a u");
    assert_eq!(shown(&bench), "ego · cp+cot+icl+tools");
}

#[test]
fn the_switch_comes_back_unless_the_configuration_says_anew() {
    let left = |configured: bool| {
        let mut bench = asking();
        bench.model.config.tools = configured;
        bench.model.tools = configured;
        bench.press("space a u");
        restore::capture(&bench.model)
    };
    let restored = |session: &Session, configured: bool| {
        let read = Session::parse(&session.text().unwrap(), &session.paths).unwrap();
        let mut again = Bench::empty();
        again.model.config.tools = configured;
        again.model.tools = configured;
        restore::restore(&mut again.model, read, false);
        again.model.tools
    };
    let (on, off) = (left(false), left(true));
    assert!(restored(&on, false), "switched on");
    assert!(!restored(&off, true), "switched off");
    assert!(restored(&on, true) && !restored(&off, false));
    // Sessions of older versions do not say, and older versions read those without a choice.
    let mut bench = asking();
    let old = restore::capture(&bench.model);
    assert!(!old.text().unwrap().contains("tools"));
    assert!(restored(&old, true) && !restored(&old, false));
    bench.press("space a u space a u");
    assert_eq!(restore::capture(&bench.model).tools, None);
}
