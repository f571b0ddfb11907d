//! `prompt`: the messages as they would be sent, and the user's own templates.

use super::CUT_IN;
use super::support::program::Home;

#[test]
fn techniques_change_the_text() {
    let home = Home::new();
    for frame in ["ego", "cartesian"] {
        for task in ["collision", "safety"] {
            let prompt = |techniques: &str| {
                let arguments = [
                    "prompt",
                    CUT_IN,
                    "--task",
                    task,
                    "--frame",
                    frame,
                    "--techniques",
                    techniques,
                ];
                home.run(&arguments).status(0).stdout
            };
            let mut texts: Vec<_> = ["base", "cp", "cot", "icl", "cp,cot", "all"]
                .map(&prompt)
                .into();
            assert_eq!(prompt("all"), prompt("cp,cot,icl"));
            assert!(texts[0].len() < texts[5].len(), "{task} {frame}");
            for text in &texts {
                assert!(
                    text.contains("[system]\n") && text.contains("\n[user]\n"),
                    "{text}"
                );
                assert!(!text.contains("{{") && !text.contains("{%"), "{text}");
            }
            texts.sort();
            texts.dedup();
            assert_eq!(
                texts.len(),
                6,
                "{task} {frame}: every choice of techniques has its text"
            );
        }
    }
}

#[test]
fn messages_are_printed_as_json() {
    let home = Home::new();
    let messages = home.run(&["prompt", CUT_IN, "--json"]).status(0).json();
    let messages = messages.as_array().unwrap();
    let roles: Vec<_> = messages
        .iter()
        .map(|m| m["role"].as_str().unwrap())
        .collect();
    assert_eq!(roles, ["system", "user"]);
    let text = home.run(&["prompt", CUT_IN]).status(0).stdout;
    for message in messages {
        assert!(text.contains(message["content"].as_str().unwrap()));
    }
}

#[test]
fn a_prompt_holds_the_description_and_no_answer() {
    let home = Home::new();
    let text = home
        .run(&["prompt", CUT_IN, "--frame", "ego"])
        .status(0)
        .stdout;
    let description = home
        .run(&["describe", CUT_IN, "--frame", "ego"])
        .status(0)
        .stdout;
    assert!(text.contains(description.trim()));
    assert!(
        !text.contains("overlaps the ego's"),
        "the built-in judge's words are not given away"
    );
}

const MINE: &str = "+++\nname = \"mine\"\nversion = \"7\"\ntask = \"collision\"\nframe = \"ego\"\n+++\n\
    {% block system %}Be mine.{% endblock %}{% block user %}In {{ scenario }}: {{ description }}{% endblock %}\n";

#[test]
fn the_users_template_overrides_the_shipped_one() {
    let home = Home::new();
    home.write(home.config().join("prompts/collision-ego.md"), MINE);
    let ended = home
        .run(&["prompt", CUT_IN])
        .status(0)
        .says(&["collision-ego.md"]);
    assert!(
        ended
            .stdout
            .contains("[system]\nBe mine.\n\n[user]\nIn ZAM_CutIn"),
        "{}",
        ended.stdout
    );
    let other = home
        .run(&["prompt", CUT_IN, "--frame", "cartesian"])
        .status(0)
        .stdout;
    assert!(!other.contains("Be mine."));
}

#[test]
fn a_broken_template_is_reported_and_the_shipped_one_used() {
    let home = Home::new();
    let shipped = home.run(&["prompt", CUT_IN]).status(0).stdout;
    home.write(
        home.config().join("prompts/collision-ego.md"),
        "no front matter",
    );
    let ended = home.run(&["prompt", CUT_IN]).status(0);
    assert_eq!(ended.stdout, shipped);
    ended.says(&["collision-ego.md", "line 1", "shipped template is used"]);
}

#[test]
fn a_template_that_cannot_be_filled_is_named_with_its_line() {
    let home = Home::new();
    let wrong = MINE.replace("{{ scenario }}", "\n{{ nothing_of_this_name }}");
    home.write(home.config().join("prompts/collision-ego.md"), wrong);
    home.run(&["prompt", CUT_IN])
        .status(2)
        .says(&["collision-ego.md:8"]);
}
