//! Generation by a model: started by a key, reported while it runs, read in the panel.

use std::sync::Arc;
use std::time::Duration;

use crate::features::generation::panel::VariantScreen;
use crate::features::generation::request::Generate;
use crate::loaded::{
    Authorship, GeneratedVariant, GenerationInputs, GenerationOutcome, GenerationProgress, Opened,
    VariantRequest,
};
use crate::message::{Effect, Msg};
use crate::model::{JobId, JobState, Model, Update};
use crate::tests::asking::right_turn;
use crate::tests::bench::{self, Bench, coarse, generated_variant, in_12_ms};
use nearmiss_ask::llm::Chunk;
use nearmiss_drive::generation::attacker::{self, Candidate};
use nearmiss_drive::generation::{AttackSetup, AttackStyle, Reason, Refusal, admit};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Scene;
use nearmiss_scene::verdict::{AttackerChoice, Motion, ObstacleRisk};
use nearmiss_store::Consumed;
use nearmiss_study::evaluation::Event;
use nearmiss_study::evaluation::generating::{
    AuthorError, Authored, AuthoredAttack, AuthoringUsage, Choice, ChosenBy, Grade, Progress,
    Proposal, Ranking, RefusedAnswer, Source,
};
use nearmiss_workflow::{AttackSource, AttackWriter};

/// What a model is wanted to say in tests.
const WORDS: &str = "It is 4 m behind and has \u{1b}[31mno\u{1b}[0m other way.\n\tSo be it.";

/// The last wish, and its number.
pub fn asked(bench: &Bench) -> (JobId, VariantRequest) {
    let mut asks = bench.effects.iter().rev();
    let ask = asks.find_map(|effect| match effect.request() {
        Some(Generate { id, request }) => Some((*id, (**request).clone())),
        _ => None,
    });
    ask.expect("a model was asked")
}

pub fn count(bench: &Bench) -> usize {
    let begun = |e: &&Effect| matches!(e.request(), Some(Generate { .. }));
    bench.effects.iter().filter(begun).count()
}

pub fn said(model: &Model) -> String {
    let last = model.toasts.last();
    last.map_or(String::new(), |toast| toast.text.clone())
}

/// The right turn, open, with a model chosen.
pub fn open() -> Bench {
    let mut bench = Bench::bundled();
    bench.press("/");
    bench.type_text("rightturn");
    bench.press("enter");
    bench.model.model = "lab/small".into();
    bench
}

/// The attack that a search finds: what the model is made to answer.
pub fn found() -> (i64, Motion) {
    let Ok(GenerationOutcome::Found { variant, .. }) = generated_variant(&right_turn()) else {
        panic!("the search finds nothing");
    };
    let made = &variant.variant.as_ref().unwrap().made;
    (made.effect.main().obstacle, made.asked[0].clone())
}

fn choice(attacker: i64, ranked: Vec<Candidate>, words: &str) -> Choice {
    let risk = |id, risk_score| ObstacleRisk {
        id,
        risk_score,
        reason: words.into(),
        written_score: None,
    };
    let vote = |attacker| Proposal {
        run: None,
        window: (1, 40),
        choice: Some(AttackerChoice {
            attacker: Some(attacker),
            obstacles: vec![risk(attacker, 1), risk(301, 3)],
            justification: words.into(),
        }),
        reasoning: words.into(),
        refused: None,
    };
    Choice {
        ranked,
        proposal: Some(vote(attacker)),
        votes: vec![vote(attacker), vote(301), vote(attacker)],
        tied: Vec::new(),
        within: Some(30.0),
        none_within: None,
        attacker: Some(attacker),
        by: ChosenBy::Model,
    }
}

/// A grade of the model.
fn grade(score: Option<u8>) -> Option<Grade> {
    Some(Grade {
        run: None,
        window: (1, 40),
        score,
        problem: score.is_none().then(|| WORDS.into()),
    })
}

fn source(sample: u32, retry: u32) -> Source {
    Source {
        sample,
        retry,
        run: None,
    }
}

fn declined(sample: u32, retry: u32, refusals: Vec<Refusal>) -> RefusedAnswer {
    RefusedAnswer {
        arrived: true,
        source: source(sample, retry),
        motion: None,
        refusals,
    }
}

/// Three answers, of which the second, sent back once, passes the gate, and a fourth that does the same.
fn authored(ground: &AttackSetup<'_>) -> Authored {
    let (id, motion) = found();
    let admitted = admit(ground, id, &motion).expect("the gate lets it through");
    let told = AuthoredAttack {
        admitted: admitted.clone(),
        source: source(3, 0),
        justification: WORDS.into(),
        reasoning: String::new(),
        feedback: Some(WORDS.into()),
        grade: grade(Some(4)),
    };
    Authored {
        choice: choice(id, attacker::rank(ground.stage), WORDS),
        attacks: vec![
            AuthoredAttack {
                admitted,
                source: source(1, 1),
                justification: WORDS.into(),
                reasoning: WORDS.repeat(3),
                feedback: None,
                grade: grade(Some(1)),
            },
            told,
        ],
        rank: Ranking::Exact,
        declined: vec![
            declined(0, 0, vec![Refusal::at(46, Reason::Jump).with(10.7, 2.5)]),
            declined(1, 0, vec![Refusal::at(30, Reason::Overlap(306))]),
            declined(2, 0, vec![Refusal::answer(format!("no JSON: {WORDS}"))]),
        ],
        spent: AuthoringUsage {
            requests: 5,
            answers: 5,
            stored: 1,
            input_tokens: 5000,
            output_tokens: 1234,
            usd: 0.0125,
            usd_before: 0.0025,
            unpriced: 0,
        },
        stopped: None,
    }
}

/// A model that answers that.
pub struct Canned;

impl AttackWriter for Canned {
    fn write(
        &self,
        ground: &AttackSetup<'_>,
        _: &Arc<Scene>,
        _: f64,
        _: &Cancel,
        _: &mut dyn FnMut(Progress),
    ) -> Result<Option<Authored>, AuthorError> {
        Ok(Some(authored(ground)))
    }
}

/// What comes of a wish where the model answers that.
fn written(wish: &VariantRequest) -> Result<GenerationOutcome, String> {
    let (settings, thresholds) = (coarse(wish.forecast), Thresholds::shipped());
    let how = GenerationInputs {
        settings: &settings,
        planner: None,
        source: AttackSource::Model(&Canned),
    };
    let (ego, cancel) = (EgoSelection::Beside, Cancel::default());
    // A folder in which nothing lies decides the name.
    let wish = VariantRequest {
        style: AttackStyle::Limit,
        folder: Some("/nonexistent".into()),
        ..wish.clone()
    };
    let mut made = Opened::generated(&wish, &ego, thresholds, &how, &cancel, &mut |_| {})?
        .expect("it was not stopped");
    in_12_ms(&mut made);
    Ok(made)
}

/// What a model wrote that came to nothing.
pub fn unwritten(words: &str) -> GenerationOutcome {
    let wrote = Authorship {
        model: words.into(),
        only: None,
        authored: Authored {
            choice: choice(305, Vec::new(), words),
            attacks: Vec::new(),
            declined: vec![declined(0, 0, vec![Refusal::answer(words)])],
            spent: AuthoringUsage::default(),
            rank: Ranking::Exact,
            stopped: None,
        },
        taken: None,
    };
    GenerationOutcome::Unwritten(words.into(), Arc::new(wrote))
}

fn made(bench: &Bench) -> &GeneratedVariant {
    &bench.model.variant().expect("a variant is shown").made
}

#[test]
fn a_key_asks_the_chosen_model_and_shows_how_far_it_is() {
    let mut bench = open();
    // Nothing is asked before its cost was seen.
    bench.press("space g m");
    assert_eq!(count(&bench), 0);
    for (columns, rows) in [(80, 24), (200, 60)] {
        let frame = bench.frame(columns, rows);
        for words in ["up to 33", "3 votes", "price unknown", "lab/small"] {
            assert!(frame.contains(words), "{words}\n{frame}");
        }
    }
    bench.press("esc");
    assert!(bench.model.screens.is_empty());
    bench.press("space g m enter");
    let (id, wish) = asked(&bench);
    let writer = wish.writer.as_ref().unwrap();
    assert_eq!(
        (writer.model.as_str(), writer.fresh, wish.only),
        ("lab/small", false, None)
    );
    assert_eq!(writer.name, wish.entry.name);
    let job = |bench: &Bench| bench.model.jobs.all.last().unwrap().clone();
    assert_eq!(
        job(&bench).title,
        format!("{} made dangerous by lab/small", wish.entry.name)
    );
    assert_eq!(bench.model.jobs.asking(), 1);
    let hear = |bench: &mut Bench, progress| {
        bench.send(Msg::reply::<Generate>((
            id,
            Update::Progress(GenerationProgress::Model(progress)),
        )));
        let frame = bench.frame(200, 60);
        frame.lines().last().unwrap().to_string()
    };
    let (vote, of) = (1, 3);
    let line = hear(&mut bench, Progress::Choosing { vote, of });
    assert!(
        line.contains("model: chooses the attacker, vote 2/3"),
        "{line}"
    );
    let event = Event::Chunk(Chunk::Retrying {
        attempt: 2,
        wait: Duration::from_secs(7),
        why: "503 \u{1b}[31mbusy".into(),
    });
    let sample = None;
    let line = hear(&mut bench, Progress::Heard { sample, event });
    assert!(
        line.contains("busy; try 2 in 7 s") && !line.contains('\u{1b}'),
        "{line}"
    );
    assert!(matches!(job(&bench).state, JobState::Waiting(_)));
    let event = Event::Chunk(Chunk::Text("{".into()));
    let line = hear(&mut bench, Progress::Heard { sample, event });
    assert!(!line.contains("busy"), "{line}");
    assert_eq!(job(&bench).state, JobState::Running);
    // Of an answer that was in the store nothing is counted.
    let consumed = Consumed {
        input_tokens: Some(1000),
        output_tokens: Some(100),
        cost_usd: Some(0.5),
        ..Consumed::default()
    };
    for stored in [true, false] {
        let answered = Progress::Answered {
            sample,
            consumed,
            stored,
        };
        hear(&mut bench, answered);
    }
    assert_eq!((job(&bench).tokens, job(&bench).cost), (1100, 0.5));
    let (sample, retry) = (1, 1);
    hear(
        &mut bench,
        Progress::Refused(Box::new(declined(0, 2, Vec::new()))),
    );
    hear(&mut bench, Progress::Ended { sample: 0 });
    let line = hear(&mut bench, Progress::Writing { sample, retry });
    let words = "model: writes motion 2/5, try 2, 0 passed, 1 refused";
    assert!(line.contains(words), "{line}");
    let line = hear(&mut bench, Progress::Driving(source(1, 1)));
    assert!(line.contains("driving against motion 2/5"), "{line}");
    hear(&mut bench, Progress::ToldOfDrive(source(1, 1)));
    let line = hear(&mut bench, Progress::Writing { sample, retry: 2 });
    assert!(line.contains("1 told what came of it"), "{line}");
    let header = bench.frame(200, 60);
    assert!(header.lines().next().unwrap().contains("$0.5000"));
    assert_eq!((job(&bench).done, job(&bench).of), (1, 5));
    assert!(bench.frame(80, 24).contains("model: writes motion 2/5"));
    let line = hear(&mut bench, Progress::Grading { motion: 0, of: 2 });
    assert!(line.contains("model: grades motion 1/2"), "{line}");
    // Who quits is asked, as something is paid for.
    bench.press("q");
    assert!(said(&bench.model).contains("1 question is running"));

    bench.send(bench::generated(id, written(&wish)));
    assert_eq!(made(&bench).by, "lab/small");
    assert!(bench.model.variant().unwrap().changed);
    assert!(said(&bench.model).starts_with("variant: 306, collision"));
    assert!(matches!(job(&bench).state, JobState::Done(_)));
    assert_eq!(bench.model.jobs.asking(), 0);
    // It is shown again, and then asked anew.
    bench.press("space e r space g m");
    assert!(count(&bench) == 1 && bench.model.variant().is_some());
    bench.press("space g m enter");
    assert!(count(&bench) == 2 && asked(&bench).1.writer.unwrap().fresh);
}

#[test]
fn it_can_be_cancelled_and_another_model_is_not_asked_anew() {
    let mut bench = open();
    bench.press("space g m enter esc esc");
    let stops = |e: &&Effect| matches!(e, Effect::Cancel(_));
    assert_eq!(bench.effects.iter().filter(stops).count(), 1);
    let state = |bench: &Bench| bench.model.jobs.all.last().unwrap().state.clone();
    assert_eq!(state(&bench), JobState::Stopping);
    let (id, _) = asked(&bench);
    bench.send(Msg::reply::<Generate>((id, Update::Cancelled)));
    assert!(matches!(state(&bench), JobState::Cancelled(_)));
    assert!(!bench.frame(80, 24).contains("cancelling…"));
    assert_eq!(said(&bench.model), "cancelled");
    // It had not said everything: the store may have half of it.
    bench.press("space g m enter");
    let (id, wish) = asked(&bench);
    assert!(count(&bench) == 2 && !wish.writer.unwrap().fresh);
    bench.send(bench::generated(id, Ok(unwritten("lab/small"))));
    bench.press("space g m enter");
    assert!(asked(&bench).1.writer.unwrap().fresh);
    bench.press("esc esc");
    bench.model.model = "lab/large".into();
    bench.press("space g m enter");
    assert!(!asked(&bench).1.writer.unwrap().fresh);
}

#[test]
fn the_panel_tells_who_wrote_it_and_what_became_of_each_answer() {
    for (columns, rows) in [(80, 24), (200, 60)] {
        let mut bench = open();
        bench.send(Msg::Resize(columns, rows));
        bench.frame(columns, rows);
        bench.press("space g m enter");
        let (id, wish) = asked(&bench);
        bench.send(bench::generated(id, written(&wish)));
        bench.model.toasts.clear();
        bench.press("tab space g v");
        bench.model.map.layers.planner = false;
        // On the small screen, from possible attackers on.
        let down = if rows < 40 { 44 } else { 34 };
        for _ in 0..down {
            bench.press("down");
        }
        let panel = bench.frame(columns, rows);
        assert!(!panel.contains('\u{1b}'));
        insta::assert_snapshot!(format!("the_authorship_at_{columns}_by_{rows}"), panel);
    }
}

#[test]
fn the_picked_obstacle_attacks_and_the_judge_writes_nothing() {
    let mut bench = open();
    bench.model.picked = Some(305);
    bench.perform("generate-with-model-by");
    bench.press("enter");
    assert_eq!(asked(&bench).1.only, Some(305));
    bench.press("esc esc");
    bench.model.model = nearmiss_scene::judge::MODEL.into();
    bench.press("space g m");
    assert_eq!(count(&bench), 1);
    let words = said(&bench.model);
    assert!(
        words.contains("m chooses a model, Space g g searches"),
        "{words}"
    );
}

#[test]
fn what_came_to_nothing_can_be_read() {
    let mut bench = open();
    bench.press("space g v");
    assert!(bench.model.screens.is_empty());
    bench.press("space g m enter");
    let (id, _) = asked(&bench);
    let nothing = unwritten("lab/\u{1b}[31msmall");
    bench.send(bench::generated(id, Ok(nothing)));
    assert!(said(&bench.model).ends_with("Space g v details"));
    bench.press("space g v");
    assert!(bench.model.screens.is_top::<VariantScreen>());
    let panel = bench.frame(200, 60);
    for words in [
        "what the model wrote",
        "1 answer, 0 passed the gate",
        "x rejected: lab/␛[31msmall",
        "305, by the model",
    ] {
        assert!(panel.contains(words), "{words}\n{panel}");
    }
    assert!(!panel.contains('\u{1b}'));
}
