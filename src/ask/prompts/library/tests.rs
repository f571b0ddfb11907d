//! Tests of the library: overriding, broken files, and selection among several templates.
#![allow(clippy::unwrap_used)]
use super::*;

#[test]
fn every_shipped_file_is_read_and_every_file_is_shipped() {
    let library = Library::load(None);
    assert_eq!(
        library.templates().count() + library.fragments().len(),
        SHIPPED.len()
    );
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../prompts");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, SHIPPED.iter().map(|s| s.file).collect::<Vec<_>>());
}

#[test]
fn a_pack_has_its_own_templates_and_no_others() {
    let library = Library::load(None);
    let file = |library: &Library, task, frame| {
        library.find(task, frame).map(|(file, _)| file.to_string())
    };
    assert_eq!(
        file(&library, "collision", "ego").as_deref(),
        Some("collision-ego.md")
    );
    let mut paper = library.clone().with_pack(Pack::Paper);
    for (task, frame) in [
        ("collision", "ego"),
        ("collision", "cartesian"),
        ("safety", "ego"),
        ("safety", "cartesian"),
    ] {
        let found = file(&paper, task, frame);
        assert_eq!(found, Some(format!("paper-{task}-{frame}.md")));
    }
    assert_eq!(file(&paper, "attacker", "ego"), None);
    // Without a pack on the command line a choice made for good holds.
    paper
        .chosen
        .set("collision", "ego", Some("paper-collision-ego.md"));
    let chosen = paper.with_pack(Pack::Standard);
    assert_eq!(
        file(&chosen, "collision", "ego").as_deref(),
        Some("paper-collision-ego.md")
    );
}

#[test]
fn the_users_file_overrides_and_a_broken_one_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let mine = Library::shipped("collision-ego.md").unwrap().replacen(
        "version = ",
        "version = \"mine\" #",
        1,
    );
    std::fs::write(file("collision-ego.md"), &mine).unwrap();
    std::fs::write(file("safety-ego.md"), "no front matter").unwrap();
    std::fs::write(file("_risk.md"), "a\n{% if %}").unwrap();
    std::fs::write(file("_new.md"), "{{").unwrap();
    let library = Library::load(Some(folder.path()));
    let (_, template) = library.find("collision", "ego").unwrap();
    assert_eq!(template.front.version, "mine");
    let kept = &library.find("safety", "ego").unwrap().1.source;
    assert_eq!(Some(kept.as_str()), Library::shipped("safety-ego.md"));
    let problems: Vec<_> = library
        .problems
        .iter()
        .map(|p| (p.path.clone(), p.instead))
        .collect();
    assert_eq!(
        problems,
        [
            (file("_new.md"), Fallback::Nothing),
            (file("_risk.md"), Fallback::Shipped),
            (file("safety-ego.md"), Fallback::Shipped)
        ]
    );
    assert!(library.problems[1].message.starts_with("line 2:"));
}

#[test]
fn a_file_that_breaks_stays_in_use_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let mine = Library::shipped("collision-ego.md").unwrap().to_string() + "\n{# mine #}";
    std::fs::write(file("collision-ego.md"), &mine).unwrap();
    std::fs::write(file("_risk.md"), "my risk").unwrap();
    let good = Library::load(Some(folder.path()));
    assert!(good.problems.is_empty());
    std::fs::write(file("collision-ego.md"), "broken").unwrap();
    std::fs::write(file("_risk.md"), "{{").unwrap();
    std::fs::write(file("safety-ego.md"), "never was good").unwrap();
    let mut library = Library::load(Some(folder.path())).or_last_good(&good);
    // A second reading keeps what the first kept.
    for _ in 0..2 {
        let (source, origin) = library.source("collision-ego.md").unwrap();
        assert_eq!(source, mine);
        assert_eq!(origin, &Origin::User(file("collision-ego.md")));
        assert_eq!(library.source("_risk.md").unwrap().0, "my risk");
        let instead: Vec<_> = library.problems.iter().map(|p| p.instead).collect();
        assert_eq!(
            instead,
            [Fallback::LastGood, Fallback::LastGood, Fallback::Shipped]
        );
        library = Library::load(Some(folder.path())).or_last_good(&library);
    }
    std::fs::remove_file(file("collision-ego.md")).unwrap();
    let library = Library::load(Some(folder.path())).or_last_good(&library);
    assert_eq!(
        library.source("collision-ego.md").unwrap().1,
        &Origin::Shipped
    );
}

#[test]
fn of_several_templates_the_chosen_one_is_used() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = Library::shipped("collision-ego.md").unwrap();
    let load = || Library::load(Some(folder.path()));
    let used = |library: &Library| library.find("collision", "ego").unwrap().0.to_string();
    for name in ["short.md", "long.md"] {
        let text = crate::prompts::renamed(shipped, name);
        std::fs::write(folder.path().join(name), text).unwrap();
        crate::prompts::choose_template(folder.path(), "collision", "ego", name).unwrap();
    }
    let library = load();
    assert_eq!(used(&library), "long.md");
    assert!(library.in_use("long.md") && !library.in_use("short.md"));
    let all: Vec<_> = library
        .candidates("collision", "ego")
        .map(|c| c.0)
        .collect();
    assert_eq!(all, ["collision-ego.md", "long.md", "short.md"]);
    crate::prompts::choose_template(folder.path(), "collision", "ego", "collision-ego.md").unwrap();
    assert_eq!(used(&load()), "collision-ego.md");
    assert!(load().problems.is_empty());
    // What overrides the shipped one by its name comes before others, where nothing is chosen.
    std::fs::remove_file(folder.path().join("chosen.toml")).unwrap();
    std::fs::write(folder.path().join("collision-ego.md"), shipped).unwrap();
    assert_eq!(used(&load()), "collision-ego.md");
    assert_eq!(
        load().overridden().collect::<Vec<_>>(),
        ["collision-ego.md"]
    );
}

#[test]
fn a_choice_that_cannot_be_kept_is_a_problem() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chosen.toml");
    for (text, word) in [
        ("[collision]\nego = 3\n", "line 2"),
        ("[collision]\nego = \"gone.md\"\n", "no template gone.md"),
        ("[collision]\nego = \"safety-ego.md\"\n", "is for safety"),
    ] {
        std::fs::write(&path, text).unwrap();
        let library = Library::load(Some(folder.path()));
        assert_eq!(
            library.find("collision", "ego").unwrap().0,
            "collision-ego.md"
        );
        let said = library.problems[0].to_string();
        assert!(
            said.contains(word) && said.contains("nothing is sent in its place"),
            "{said}"
        );
    }
}
