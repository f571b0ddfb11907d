//! Answers side by side, and their ratings.

use crate::features::answers::LoadStored;
use crate::features::compare::rating::{FindUnrated, Rate, ReadRatings};
use crate::keymap::Key;
use crate::message::{Effect, Msg};
use crate::model::ShownAnswer;
use crate::tests::answers::{asking, stored_of};
use crate::tests::bench::{self, Bench, answer};
use nearmiss_ask::llm::Chunk;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Choice, NewRating, RatedAnswer, Rating, RunId, Unrated};
use nearmiss_study::evaluation::{Answer, Event};

const CLAIMS: &str = "### Obstacle 301\n\nObstacle 301 is at a distance of 999 m at step 20. It is **fast**.\n\n\
    Obstacle 302 is behind the ego.";

/// Two answers with claims, of models whose names must not be seen in blind mode.
pub fn two() -> Bench {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let said = |model: &str, dangerous, run, text: &str| Answer {
        run: Some(RunId(run)),
        text: text.into(),
        reasoning: String::new(),
        ..answer(model, dangerous, 301)
    };
    let long = format!("As Mammoth I say.\n{}", "a line\n".repeat(200));
    let answers = vec![
        said("lab/walrus", true, 7, CLAIMS),
        said("lab/mammoth", false, 8, &long),
    ];
    bench.send(Msg::reply::<LoadStored>((of, answers)));
    bench
}

pub fn sized(mut bench: Bench, columns: u16, rows: u16) -> Bench {
    bench.send(Msg::Resize(columns, rows));
    bench
}

fn rating(bench: &Bench) -> NewRating {
    let mut rated = bench
        .effects
        .iter()
        .rev()
        .filter_map(|e| match e.request() {
            Some(Rate { rating, .. }) => Some((**rating).clone()),
            _ => None,
        });
    rated.next().expect("something was rated")
}

fn place_of(bench: &Bench, model: &str) -> usize {
    let of = |shown: &ShownAnswer| matches!(shown, ShownAnswer::Column(i) if bench.model.answers.columns[*i].model == model);
    bench.model.compare.shown.iter().position(of).unwrap()
}

#[test]
fn at_80_by_24() {
    let mut bench = sized(two(), 80, 24);
    bench.press("space o c");
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn at_200_by_60() {
    let mut bench = sized(two(), 200, 60);
    bench.press("space o c");
    bench.model.compare.focus = place_of(&bench, "lab/walrus");
    bench.frame(200, 60);
    bench.press("n");
    insta::assert_snapshot!(bench.frame(200, 60));
}

#[test]
fn blind_at_80_by_24() {
    let mut bench = sized(two(), 80, 24);
    bench.press("space o b");
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn a_claim_picks_its_obstacle_and_its_step() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c");
    bench.model.compare.focus = place_of(&bench, "lab/walrus");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("m≠"), "{frame}");
    assert!(frame.contains("301: claimed 999 m, actual "), "{frame}");
    bench.press("n");
    assert_eq!(
        (bench.model.picked, bench.model.clock.step()),
        (Some(301), 20)
    );
    bench.press("n");
    assert_eq!(bench.model.picked, Some(302));
    bench.press("shift-n esc");
    assert!(!bench.model.compare.open);
    assert_eq!(bench.model.picked, Some(301));
    // The pane of one answer has them too.
    let place = bench
        .model
        .answers
        .columns
        .iter()
        .position(|c| c.model == "lab/walrus")
        .unwrap();
    bench.model.answers.show(ShownAnswer::Column(place));
    bench.model.picked = None;
    bench.press(")");
    assert!(bench.model.picked.is_some());
    let frame = bench.frame(120, 40);
    assert!(frame.contains("m≠"), "{frame}");
}

#[test]
fn it_says_how_many_answers_there_are_and_rates_none_out_of_sight() {
    let mut bench = sized(two(), 80, 24);
    bench.press("space o c");
    let frame = bench.frame(80, 24);
    assert!(frame.contains(" · 2 answers · "), "{frame}");
    let last = frame.lines().last().unwrap();
    assert!(last.starts_with(" [] answer  1 2 best "), "{last}");
    let columns = |frame: &str| {
        frame
            .lines()
            .skip(1)
            .take(15)
            .collect::<Vec<_>>()
            .join("\n")
    };
    let before = columns(&frame);
    bench.press("+");
    let frame = bench.frame(80, 24);
    // What is the same for those in sight may not be so for the third.
    let below = |columns: &str| columns.split_once('\n').map(|(_, rest)| rest.to_string());
    let after = columns(&frame);
    assert!(after.starts_with(" in sight: asked "), "{frame}");
    assert_eq!(below(&after), below(&before), "those in sight stay");
    assert!(frame.contains(" · columns 1–2 of 3"), "{frame}");
    assert!(frame.contains(" 1 2 best "), "{frame}");
    bench.press("3");
    assert_eq!(bench.model.compare.choice, None);
    bench.press("right right");
    assert!(bench.frame(80, 24).contains(" 2 3 best "));
    bench.press("3");
    assert_eq!(bench.model.compare.choice, Some(Choice::Best(2)));
}

#[test]
fn a_sign_says_that_answers_differ_and_others_what_is_exact() {
    let mut bench = sized(two(), 80, 24);
    bench.press("space o c");
    let frame = bench.frame(80, 24);
    let row = |name: &str| frame.lines().find(|line| line.contains(name)).unwrap();
    assert!(row("verdict ◆").contains("no collision ≠"), "{frame}");
    assert!(row("risk ◆").contains("3 ≠ 0"), "{frame}");
    assert!(row("risk ◆").contains("0 ="), "{frame}");
    assert!(frame.contains("◆ answers differ · = ≠ exact"), "{frame}");
}

#[test]
fn a_claim_far_down_a_paragraph_comes_into_sight() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let text = format!(
        "{}Obstacle 301 is at a distance of 999 m at step 20. {}",
        "Words before it. ".repeat(60),
        "Words after it. ".repeat(60)
    );
    let answers = vec![Answer {
        run: Some(RunId(7)),
        text,
        reasoning: String::new(),
        ..answer("lab/walrus", true, 301)
    }];
    bench.send(Msg::reply::<LoadStored>((of, answers)));
    let mut bench = sized(bench, 80, 24);
    bench.model.answers.show(ShownAnswer::Column(0));
    bench.frame(80, 24);
    bench.press(")");
    let frame = bench.frame(80, 24);
    assert!(frame.contains("m≠"), "{frame}");
    bench.model.claims.picked = None;
    bench.press("space o c");
    bench.frame(80, 24);
    bench.press("n");
    let frame = bench.frame(80, 24);
    assert!(frame.contains("999 m≠"), "{frame}");
}

#[test]
fn a_claim_in_wrapped_json_comes_into_sight() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let text = format!(
        "{0}{{\n  \"collision\": false,\n  \"obstacles\": [\n    {{\"id\": 301, \"risk_score\": 2, \"reason\": \"{1}\
         Obstacle 301 is at a distance of 999 m at step 20.\"}}\n  ]\n}}\n",
        "Obstacle 302 is at a distance of 888 m at step 20.\n\n".repeat(9),
        "Much is said. ".repeat(20)
    );
    let answers = vec![Answer {
        run: Some(RunId(7)),
        text,
        reasoning: String::new(),
        ..answer("lab/walrus", true, 301)
    }];
    bench.send(Msg::reply::<LoadStored>((of, answers)));
    let mut bench = sized(bench, 80, 24);
    bench.model.answers.show(ShownAnswer::Column(0));
    bench.press("space o c");
    bench.frame(80, 24);
    // The one before it, the risk score, and this one.
    bench.press("n n n");
    let frame = bench.frame(80, 24);
    assert!(frame.contains("999 m≠"), "{frame}");
}

#[test]
fn it_begins_at_the_answer_that_was_shown() {
    for column in 0..2 {
        let mut bench = sized(two(), 120, 40);
        bench.model.answers.show(ShownAnswer::Column(column));
        bench.press("space o c");
        let compare = &bench.model.compare;
        assert_eq!(compare.shown[compare.focus], ShownAnswer::Column(column));
    }
}

#[test]
fn columns_scroll_together_or_alone() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c");
    let (long, short) = (
        place_of(&bench, "lab/mammoth"),
        place_of(&bench, "lab/walrus"),
    );
    bench.model.compare.focus = long;
    bench.frame(120, 40);
    bench.press("down down down");
    bench.frame(120, 40);
    bench.press("s shift-g");
    bench.frame(120, 40);
    let top = bench.model.drawn.column(long).top;
    assert!(top > 100, "{top}");
    assert_eq!(bench.model.drawn.column(short).top, 0, "it has no more");
    bench.model.compare.focus = short;
    bench.press("up");
    assert_eq!(bench.model.drawn.column(long).top, top);
}

#[test]
fn what_arrives_is_followed_until_somebody_scrolls_up() {
    let mut bench = sized(asking(), 120, 40);
    let (id, _) = bench.asked();
    bench.press("space o c");
    let place = place_of(&bench, "lab/small");
    bench.model.compare.focus = place;
    let line = |n: usize| bench::piece(id, Event::Chunk(Chunk::Text(format!("line {n}\n"))));
    (0..60).for_each(|n| bench.send(line(n)));
    assert!(bench.frame(120, 40).contains("line 59"));
    bench.press("up up");
    (60..90).for_each(|n| bench.send(line(n)));
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("new lines below, G follows") && !frame.contains("line 89"),
        "{frame}"
    );
    bench.press("shift-g");
    bench.send(line(90));
    assert!(bench.frame(120, 40).contains("line 90"));
    bench.press("1");
    assert!(
        !bench
            .effects
            .iter()
            .any(|e| matches!(e.request(), Some(Rate { .. }))),
        "it is not whole"
    );
}

/// Whether the verdicts say who agrees with the built-in judge, or differs from it.
fn agrees(frame: &str) -> bool {
    let row = frame
        .lines()
        .find(|line| line.contains("verdict "))
        .unwrap();
    row.contains(['=', '≠'])
}

#[test]
fn blind_mode_hides_whose_answers_they_are_until_one_is_chosen() {
    let mut bench = sized(two(), 120, 40);
    for column in &mut bench.model.answers.columns {
        column.reasoning = "Let me think step by step.".into();
    }
    // Of a model without a column.
    bench.model.tell("lab/otter: collision, saved as run 2");
    bench.press("space o b");
    assert!(!bench.frame(120, 40).contains("otter"));
    bench.model.say("lab/walrus: done");
    let secrets = [
        "step by step",
        "walrus",
        "mammoth",
        "lab/",
        "2,000",
        "6.1 s",
        "ego · base",
        "run 7",
    ];
    for size in [(80, 24), (120, 40), (200, 60)] {
        let frame = bench.frame(size.0, size.1).to_lowercase();
        for secret in secrets {
            assert!(!frame.contains(secret), "{secret}: {frame}");
        }
        assert!(frame.contains("as ******* i say"), "{frame}");
        assert!(!agrees(&frame), "{frame}");
    }
    bench.press("right left w down");
    bench.type_text("it is 302");
    bench.press("enter");
    let better = place_of(&bench, "lab/walrus");
    let focus = bench.model.compare.focus;
    bench.press(&(better + 1).to_string());
    let rated = rating(&bench);
    assert!(rated.blind && rated.task == Task::Collision);
    assert_eq!(rated.choice, Choice::Best(better));
    assert_eq!(rated.answers[better].run, Some(RunId(7)));
    assert_eq!(rated.answers[better].model, "lab/walrus");
    assert_eq!(rated.answers[1 - better].prompt, "ego · base");
    assert_eq!(
        rated.answers[focus].reason.as_deref(),
        Some("wrong obstacle: it is 302")
    );
    assert_eq!(rated.seed, bench.model.compare.blind.as_ref().unwrap().seed);
    assert!(
        bench.frame(120, 40).contains("lab/walrus"),
        "now it may be known"
    );
    assert!(agrees(&bench.frame(120, 40)));
    bench.send(Msg::reply::<Rate>((bench.model.compare.round, Ok(1))));
    bench.press(&(better + 1).to_string());
    let count = bench
        .effects
        .iter()
        .filter(|e| matches!(e.request(), Some(Rate { .. })))
        .count();
    assert_eq!(count, 1, "once is enough");
}

#[test]
fn blind_mode_goes_on_to_the_next_scenario() {
    let mut bench = sized(two(), 120, 40);
    let before = bench.model.opened.as_ref().unwrap().name.clone();
    bench.press("space o b t enter");
    // Which scenario has something to rate is asked of the store.
    let asks = |effect: &&Effect| {
        matches!(
            effect.request(),
            Some(FindUnrated {
                task: Task::Collision,
                ..
            })
        )
    };
    assert_eq!(bench.effects.iter().filter(asks).count(), 2);
    let list = &bench.model.list;
    let other = list.rows[*list.visible.last().unwrap()].entry.name.clone();
    let left = |scenarios: &[&str]| Unrated {
        scenarios: scenarios.iter().map(|name| ((*name).into(), 2)).collect(),
        rated: [RunId(5)].into(),
    };
    bench.send(Msg::reply::<FindUnrated>(Ok(left(&[&other]))));
    assert_ne!(other, before);
    assert_eq!(bench.model.opened.as_ref().unwrap().name, other);
    assert!(bench.frame(120, 40).contains("no stored answers"));
    let mut answers = ["lab/a", "lab/b", "lab/c", "lab/d"].map(|model| answer(model, true, 301));
    answers[3].run = Some(RunId(5));
    let of = stored_of_last(&bench);
    bench.send(Msg::reply::<LoadStored>((of, answers.to_vec())));
    // As many columns as fit; what was rated before does not come again.
    assert_eq!(bench.model.compare.shown.len(), 3);
    let rated = |shown: &ShownAnswer| *shown == place_of_model(&bench, "lab/d");
    assert!(!bench.model.compare.shown.iter().any(rated));
    bench.press("-");
    let mut seen = std::collections::BTreeSet::new();
    for _ in 0..3 {
        let mut pair = bench.model.compare.shown.clone();
        pair.sort_by_key(|s| format!("{s:?}"));
        seen.insert(format!("{pair:?}"));
        bench.press("0 enter");
    }
    assert_eq!(seen.len(), 3, "every pair once: {seen:?}");
    // No other scenario is left: it stays, and says so.
    assert_eq!(bench.model.opened.as_ref().unwrap().name, other);
    let said = &bench.model.toasts.last().unwrap().text;
    assert!(said.contains("no more answers"), "{said}");
}

fn place_of_model(bench: &Bench, model: &str) -> ShownAnswer {
    let mut columns = bench.model.answers.columns.iter();
    ShownAnswer::Column(columns.position(|c| c.model == model).unwrap())
}

fn stored_of_last(bench: &Bench) -> crate::features::answers::StoredOf {
    let mut all = bench
        .effects
        .iter()
        .rev()
        .filter_map(|e| match e.request() {
            Some(LoadStored(of)) => Some(of.clone()),
            _ => None,
        });
    all.next().unwrap()
}

#[test]
fn ratings_are_summed_up() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c shift-s");
    assert!(matches!(
        bench.effects.last().and_then(Effect::request),
        Some(ReadRatings)
    ));
    let answer = |model: &str| RatedAnswer {
        run: None,
        model: model.into(),
        prompt: "ego · base".into(),
        wrong: false,
        reason: None,
        template: None,
    };
    let rating = |choice| Rating {
        id: 1,
        created_ms: 0,
        person: "ada".into(),
        scenario: "s".into(),
        task: Task::Collision,
        blind: true,
        seed: 3,
        choice,
        notes: String::new(),
        answers: vec![answer("lab/a"), answer("lab/b")],
    };
    let all = [
        Choice::Best(0),
        Choice::Best(0),
        Choice::Best(1),
        Choice::Tie,
    ]
    .map(rating);
    bench.send(Msg::reply::<ReadRatings>(Ok(all.to_vec())));
    for size in [(80, 24), (120, 40)] {
        let frame = bench.frame(size.0, size.1);
        // 2.5 to 1.5: ln(5/3)/2 = 0.26.
        assert!(
            frame.contains("4 ratings, 4 of them blind") && frame.contains("+0.26 ("),
            "{frame}"
        );
    }
    bench.press("x n");
    assert!(
        bench.model.compare.ratings.is_some(),
        "other keys leave it open"
    );
    bench.press("q");
    assert!(bench.model.compare.open && bench.model.compare.ratings.is_none());
}

#[test]
fn no_size_and_no_key_does_harm() {
    let mut bench = two();
    for open in ["space o c", "space o b"] {
        bench.press(open);
        for (columns, rows) in [(80, 24), (81, 25), (109, 33), (300, 90), (10, 3)] {
            bench.send(Msg::Resize(columns, rows));
            bench.frame(columns, rows);
            for key in [
                "right", "+", "+", "-", "]", "[", "n", "N", "w", "x", "enter", "2", "t", "enter",
                ".", "G", "g", "s", "(", "]",
            ] {
                bench.send(Msg::Key(Key::parse(key).unwrap()));
                bench.frame(columns, rows);
            }
        }
        bench.press("esc esc");
        bench.model.compare.open = false;
    }
    let mut empty = Bench::empty();
    empty.press("space o c shift-b 1 n enter w s ctrl-c");
    empty.frame(80, 24);
}

#[test]
fn the_palette_rates_nothing_that_is_not_on_the_screen() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c esc space a x space a x");
    assert!(bench.model.answers.columns.is_empty());
    for name in ["tie", "all-wrong", "best-1", "mark-wrong"] {
        bench.perform(name);
        let rated = bench
            .effects
            .iter()
            .any(|e| matches!(e.request(), Some(Rate { .. })));
        assert!(!rated && bench.model.compare.open, "{name}");
        bench.press("esc");
    }
}

#[test]
fn answers_that_come_after_it_was_opened_stand_there_too() {
    let mut bench = sized(Bench::bundled(), 120, 40);
    let of = stored_of(&bench);
    bench.press("space o c");
    assert_eq!(bench.model.compare.shown, [ShownAnswer::Reference]);
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![answer("lab/a", true, 301)],
    )));
    assert_eq!(
        bench.model.compare.shown,
        [ShownAnswer::Column(0), ShownAnswer::Reference]
    );
}

/// What was sent to the store: what was chosen, how many answers were marked, and which rating that replaces.
fn sent(bench: &Bench) -> Vec<(Choice, usize, Option<i64>)> {
    let effects = bench.effects.iter();
    let rated = effects.filter_map(|effect| match effect.request() {
        Some(Rate {
            rating, replaced, ..
        }) => {
            let marked = rating.answers.iter().filter(|answer| answer.wrong).count();
            Some((rating.choice, marked, *replaced))
        }
        _ => None,
    });
    rated.collect()
}

#[test]
fn answers_are_rated_anew_while_they_stand_there() {
    for open in ["space o c", "space o b"] {
        let mut bench = sized(two(), 120, 40);
        bench.press(open);
        let round = bench.model.compare.round;
        bench.press("1");
        bench.send(Msg::reply::<Rate>((round, Ok(4))));
        bench.press("2");
        bench.send(Msg::reply::<Rate>((round, Ok(4))));
        assert!(bench.frame(120, 40).contains("rating 4 changed"), "{open}");
        bench.press("w enter");
        bench.send(Msg::reply::<Rate>((round, Ok(4))));
        bench.press("w");
        let (best, again) = (Choice::Best, Some(4));
        let anew = [
            (best(1), 0, again),
            (best(1), 1, again),
            (best(1), 0, again),
        ];
        let all = [&[(best(0), 0, None)][..], &anew].concat();
        assert_eq!(sent(&bench), all, "{open}");
        // The last one is refused: what is in the store is what is shown.
        bench.send(Msg::reply::<Rate>((
            round,
            Err("the store is locked".into()),
        )));
        bench.press("t");
        bench.send(Msg::reply::<Rate>((
            round,
            Err("the store is locked".into()),
        )));
        assert_eq!(bench.model.compare.choice, Some(best(1)), "{open}");
    }
}

#[test]
fn a_rating_waits_for_the_one_before_it_and_other_answers_have_their_own() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c");
    let round = bench.model.compare.round;
    bench.press("1 2 t");
    assert_eq!(sent(&bench), [(Choice::Best(0), 0, None)]);
    // Meanwhile other answers stand there; nothing was made of them yet.
    bench.press("esc space o c");
    bench.send(Msg::reply::<Rate>((round, Ok(4))));
    assert_eq!(sent(&bench)[1..], [(Choice::Tie, 0, Some(4))]);
    bench.send(Msg::reply::<Rate>((round, Ok(4))));
    assert_eq!(bench.model.compare.choice, None);
    bench.press("0");
    assert_eq!(sent(&bench)[2..], [(Choice::AllWrong, 0, None)]);
    bench.send(Msg::reply::<Rate>((
        bench.model.compare.round,
        Err("the store is locked".into()),
    )));
    assert_eq!(bench.model.compare.choice, None);
}

/// Answers of two models with these texts, side by side.
fn beside(texts: [&str; 2]) -> Bench {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let models = ["lab/walrus", "lab/mammoth"]
        .into_iter()
        .zip(texts)
        .zip(7..);
    let said = models.map(|((model, text), run)| Answer {
        run: Some(RunId(run)),
        text: text.into(),
        reasoning: String::new(),
        ..answer(model, true, 301)
    });
    bench.send(Msg::reply::<LoadStored>((of, said.collect())));
    bench = sized(bench, 160, 40);
    bench.press("space o c");
    bench.model.compare.focus = place_of(&bench, "lab/walrus");
    bench.frame(160, 40);
    bench
}

#[test]
fn linked_columns_scroll_to_where_they_speak_of_the_same_obstacle() {
    let text = |before: usize| {
        let lines = |count: usize| "a line\n\n".repeat(count);
        let said = "Obstacle 301 is at a distance of 999 m at step 20.\n\n";
        let end = "Obstacle 302 is behind the ego.\n\n";
        format!("{}{said}{}{end}{}", lines(before), lines(50), lines(60))
    };
    let mut bench = beside([&text(60), &text(30)]);
    let beside = |bench: &Bench, words: &str| {
        let frame = bench.frame(160, 40);
        let mut lines = frame.lines();
        lines.any(|line| line.matches(words).count() == 2)
    };
    assert!(!beside(&bench, "Obstacle 301"));
    bench.press("n");
    assert!(beside(&bench, "Obstacle 301"), "{}", bench.frame(160, 40));
    for _ in 0..2 {
        bench.press("}");
        let words = format!("Obstacle {}", bench.model.picked.unwrap());
        assert!(beside(&bench, &words), "{}", bench.frame(160, 40));
    }
    // Each on its own.
    bench.press("s g g");
    bench.frame(160, 40);
    bench.press("n");
    assert!(!beside(&bench, "Obstacle 301"));
}

#[test]
fn claims_are_listed_once_the_wrong_ones_first() {
    let text = "Obstacle 302 is behind the ego at step 20.\n\nCar 301 wobbles by 7.77 m sideways, oddly.\n\n\
        Obstacle 301 is at a distance of 999 m at step 20.\n\nAgain: obstacle 301 is at a distance of 999 m at step 20.";
    let bench = beside([text, "nothing"]);
    let frame = bench.frame(160, 40);
    let mut rows = frame.lines().filter_map(|line| line.split_once("││"));
    let rows: Vec<&str> = rows.by_ref().map(|(_, words)| words).collect();
    let place = |words: &str| rows.iter().position(|row| row.contains(words));
    let wrong = place("≠ 301: claimed 999 m");
    assert!(rows[wrong.unwrap()].contains(" ×2"), "{frame}");
    assert_eq!(frame.matches("claimed 999 m").count(), 1, "{frame}");
    let unread = place("… not understood: Car 301 wobbles");
    assert!(unread.is_some() && wrong < unread, "{frame}");
    let right = place("= 302: claimed behind").or(place("≠ 302: claimed behind"));
    assert!(right.is_some(), "{frame}");
}

#[test]
fn blind_mode_counts_answers() {
    let mut bench = sized(two(), 160, 40);
    bench.press("space o b");
    let frame = bench.frame(160, 40);
    assert!(frame.contains(" · 2 answers · "), "{frame}");
}

#[test]
fn it_opens_on_answers_of_one_frame_that_differ() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let said = [
        ("lab/a", "ego · cot", true),
        ("lab/b", "ego · cot", true),
        ("lab/c", "ego · cot", false),
        ("lab/d", "cartesian · cot", false),
    ];
    let answers = said
        .into_iter()
        .zip(7..)
        .map(|((model, how, yes), run)| Answer {
            run: Some(RunId(run)),
            how: how.into(),
            ..answer(model, yes, 301)
        });
    bench.send(Msg::reply::<LoadStored>((of, answers.collect())));
    let mut bench = sized(bench, 80, 24);
    bench.press("space o c");
    assert_eq!(
        (place_of(&bench, "lab/a"), place_of(&bench, "lab/c")),
        (0, 1)
    );
    let frame = bench.frame(80, 24);
    assert!(frame.contains(" · 2 of 4 answers"), "{frame}");
}

#[test]
fn the_first_claim_gone_to_is_a_wrong_one_of_any_column() {
    let said = |metres: &str| format!("Obstacle 301 is at a distance of {metres} m at step 20.");
    let mut bench = beside([&said("999"), &said("12.6")]);
    let (wrong, right) = (
        place_of(&bench, "lab/walrus"),
        place_of(&bench, "lab/mammoth"),
    );
    bench.model.compare.focus = right;
    bench.press("n");
    assert_eq!(bench.model.compare.focus, wrong);
    // From then on the user says in which column.
    bench.model.compare.focus = right;
    bench.press("n");
    assert_eq!(bench.model.compare.focus, right);
}
