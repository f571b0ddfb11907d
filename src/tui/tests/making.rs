//! Scenarios made dangerous by a search.

use crate::features::generation::panel::VariantScreen;
use crate::features::generation::request::{Generate, SaveVariant, write};
use crate::features::map::state::On;
use crate::features::pictures::save;
use crate::loaded::{
    GeneratedVariant, GenerationOutcome, GenerationStage, VariantRequest, VariantShown,
};
use crate::message::{Effect, Msg};
use crate::model::{Drives, JobId, JobState};
use crate::services::Drawing;
use crate::tests::bench::{self, Bench, generated_variant};
use nearmiss_drive::generation::{Consequence, Progress};
use nearmiss_formats::commonroad;
use nearmiss_scene::scenario::{ContentHash, ObstacleRole, Scenario};

/// The searches that were asked for.
pub fn asked(bench: &Bench) -> Vec<(JobId, VariantRequest)> {
    let asks = bench
        .effects
        .iter()
        .filter_map(|effect| match effect.request() {
            Some(Generate { id, request }) => Some((*id, (**request).clone())),
            _ => None,
        });
    asks.collect()
}

pub fn stopped(bench: &Bench) -> usize {
    let stop = |effect: &&Effect| matches!(effect, Effect::Cancel(_));
    bench.effects.iter().filter(stop).count()
}

/// The last search that was asked for ends.
pub fn arrive(bench: &mut Bench) {
    let (id, wish) = asked(bench).pop().expect("a search was asked for");
    bench.send(bench::generated(id, generated_variant(&wish)));
}

/// A bundled scenario that is open.
pub fn open(name: &str) -> Bench {
    let mut bench = Bench::bundled();
    bench.press("/");
    bench.type_text(name);
    bench.press("enter");
    bench
}

/// One that was made dangerous.
pub fn dangerous() -> Bench {
    let mut bench = open("rightturn");
    bench.press("space g g");
    arrive(&mut bench);
    assert!(bench.model.variant().is_some(), "{}", said(&bench));
    bench
}

pub fn said(bench: &Bench) -> String {
    let last = bench.model.toasts.last();
    last.map_or(String::new(), |toast| toast.text.clone())
}

pub fn shown(bench: &Bench) -> &VariantShown {
    bench.model.variant().expect("a variant is shown")
}

pub fn made(bench: &Bench) -> &GeneratedVariant {
    &shown(bench).made
}

fn hash(bench: &Bench) -> ContentHash {
    bench.model.opened.as_ref().unwrap().scenario.hash
}

#[test]
fn a_key_makes_it_dangerous_and_shows_how_far_it_is() {
    let mut bench = open("rightturn");
    bench.press("space g g");
    let (id, wish) = asked(&bench).pop().unwrap();
    assert_eq!((wish.only, wish.seed), (None, 1));
    assert_eq!(wish.forecast, bench.model.driver.forecast);
    let progress = Progress {
        tried: 210,
        refused: 96,
        driven: 5,
        best: Some(Consequence::NearMiss),
    };
    bench.send(bench::generating(id, GenerationStage::Driving(3, 90)));
    assert!(
        bench
            .frame(120, 40)
            .contains("driving the original, step 3/90")
    );
    let searching = GenerationStage::Searching(progress, 600);
    bench.send(bench::generating(id, searching));
    let wide = bench.frame(200, 60);
    let words = "generating: motion 210 of 600, 96 refused, 5 driven, best near miss";
    assert!(wide.contains(words), "{wide}");
    assert!(bench.frame(80, 24).contains("trying motion 210/600"));
    let job = bench.model.jobs.all.last().unwrap();
    assert_eq!((job.done, job.of), (210, 600));
    assert!(bench.model.variant().is_none(), "not before it is found");

    let before = hash(&bench);
    arrive(&mut bench);
    let (effect, attacker) = (&made(&bench).effect, made(&bench).effect.main().obstacle);
    let Consequence::Collision(collision) = effect.consequence else {
        panic!("{:?}", effect.consequence);
    };
    assert_eq!(bench.model.clock.step(), collision.step);
    assert_eq!(bench.model.picked, Some(attacker));
    assert_eq!(bench.model.plot.drives, Some(Drives::Risk));
    let with = match collision.with {
        one if one == attacker => String::new(),
        other => format!(" with {other}"),
    };
    assert!(said(&bench).contains(&format!("collision{with} at ")));
    let frame = bench.frame(200, 60);
    assert!(
        frame.contains("variant · ego planned, collision"),
        "{frame}"
    );
    assert!(frame.contains("⠒⠒after 0 · ⠂⠀⠂before"), "{frame}");
    assert!(frame.contains("contact attacker"), "{frame}");
    assert!(frame.contains(&format!("{attacker} recorded")), "{frame}");
    let job = bench.model.jobs.all.last().unwrap();
    assert_eq!(
        job.state,
        JobState::Done(format!("collision, attacker {attacker}"))
    );
    // Answers about it are no answers about the original.
    let opened = bench.model.opened.as_ref().unwrap();
    assert_ne!(opened.scenario.hash, before);
    assert_ne!(opened.name, wish.entry.name);
    assert_eq!(made(&bench).original(), before);
}

#[test]
fn original_and_variant_take_turns_and_both_can_be_left() {
    let mut bench = dangerous();
    let (step, variant) = (bench.model.clock.step() - 3, hash(&bench));
    bench.model.clock.go(step);
    let attacker = made(&bench).effect.main().obstacle;
    let place = |bench: &Bench| {
        let opened = bench.model.opened.as_ref().unwrap();
        let obstacle = opened.scenario.obstacle(attacker).unwrap();
        obstacle.motion_at(step).unwrap().pose.position
    };
    let changed = place(&bench);
    bench.press("space g o");
    assert!(!shown(&bench).changed);
    assert_eq!(hash(&bench), made(&bench).original());
    assert_eq!(bench.model.clock.step(), step, "the clock stays");
    assert!((place(&bench) - changed).norm() > 0.1);
    assert!(bench.model.planned().is_some());
    let frame = bench.frame(200, 60);
    assert!(frame.contains("original · ego planned"), "{frame}");
    for words in ["changed", "recorded"] {
        let words = format!("{attacker} {words}");
        assert!(frame.contains(&words), "{words}\n{frame}");
    }
    assert!(!frame.contains("attacker "), "{frame}");
    bench.press("space g o");
    assert!(shown(&bench).changed && hash(&bench) == variant);
    // What the planner is told belongs to the variant.
    bench.press("space e f");
    assert!(said(&bench).contains("the variant belongs to this prediction"));
    assert!(bench.model.driver.under_way.is_none());

    bench.press("space e r");
    assert!(bench.model.variant().is_none() && bench.model.planned().is_none());
    assert_eq!(bench.model.plot.drives, None);
    bench.press("space g v");
    assert!(bench.model.screens.is_empty());
    bench.press("space g g");
    assert_eq!(asked(&bench).len(), 1, "it is shown again, not made again");
    assert!(shown(&bench).changed);
    bench.press("space g g");
    let (_, wish) = asked(&bench).pop().unwrap();
    assert_eq!((asked(&bench).len(), wish.seed), (2, 2), "the next seed");
    // Twice for the search, once for the filter.
    bench.press("esc esc esc down up");
    assert!(bench.model.variant().is_none());
    bench.press("space g o");
    assert!(shown(&bench).changed, "it is kept");
}

#[test]
fn that_nothing_is_found_or_can_be_tried_is_said() {
    let mut bench = open("rightturn");
    bench.press("space g g");
    let (id, _) = asked(&bench).pop().unwrap();
    let words = "no dangerous motion found for any obstacle with seed 1";
    let nothing = GenerationOutcome::Nothing(words.into());
    bench.send(bench::generated(id, Ok(nothing)));
    assert_eq!(
        said(&bench),
        format!("{words}; Space g g tries another seed")
    );
    // It stays longer than replies to keys.
    bench.send(Msg::Passed(std::time::Duration::from_secs(30)));
    assert!(said(&bench).contains(words));
    assert!(bench.model.generation.under_way.is_none());
    bench.press("space g g");
    let (id, wish) = asked(&bench).pop().unwrap();
    assert_eq!(wish.seed, 2);
    let why = "no way leads from the start to the goal";
    bench.send(bench::generated(id, Err(why.into())));
    let failed = format!("no variant was made: {why}; the same key tries again");
    assert_eq!(said(&bench), failed);
    bench.press("space g o");
    assert_eq!(said(&bench), failed);
    bench.perform("save-variant");
    assert!(said(&bench).starts_with("nothing to write: "));

    let mut opened = (**bench.model.opened.as_ref().unwrap()).clone();
    let mut scenario = Scenario::clone(&opened.scenario);
    scenario.planning_problems.clear();
    opened.scenario = scenario.into();
    bench.model.opened = Some(Box::new(opened));
    bench.press("space g g");
    assert_eq!(asked(&bench).len(), 2);
    assert!(said(&bench).contains("no planning problem"));
}

#[test]
fn the_picked_obstacle_attacks_if_it_can() {
    let mut bench = open("rightturn");
    let opened = bench.model.opened.as_ref().unwrap();
    let mut obstacles = opened.scenario.obstacles.iter();
    let moving = obstacles
        .find(|o| o.role == ObstacleRole::Dynamic)
        .unwrap()
        .id;
    let mut obstacles = opened.scenario.obstacles.iter();
    let parked = obstacles
        .find(|o| o.role == ObstacleRole::Static)
        .map(|o| o.id);
    bench.model.picked = None;
    bench.press("space g a");
    assert!(said(&bench).contains("pick the attacker first"));
    if let Some(parked) = parked {
        bench.model.picked = Some(parked);
        bench.press("space g a");
        assert!(said(&bench).contains("does not move by itself"));
    }
    assert!(asked(&bench).is_empty());
    bench.model.picked = Some(moving);
    bench.press("space g a");
    let (_, wish) = asked(&bench).pop().unwrap();
    assert_eq!(wish.only, Some(moving));
}

#[test]
fn terms_describe_an_attack() {
    let mut bench = open("rightturn");
    bench.press("space g d");
    bench.press("esc");
    bench.press("space g d");
    bench.press("enter");
    assert!(asked(&bench).is_empty() && said(&bench).contains("expected terms"));
    bench.type_text("giraffe");
    assert!(bench.frame(100, 30).contains("unknown term `giraffe`"));
    bench.press("enter");
    assert!(asked(&bench).is_empty() && said(&bench).contains("unknown term `giraffe`"));
    for _ in "giraffe".chars() {
        bench.press("backspace");
    }
    bench.type_text("actor:car manoeuvre:cut_in");
    bench.press("enter");
    let (_, request) = asked(&bench).pop().unwrap();
    assert_eq!(request.seed, 1, "the closed line used none up");
    let wish = request.wish.unwrap();
    assert_eq!(wish.to_string(), "actor:car manoeuvre:cut-in");
    assert!(said(&bench).contains("searching for an attack: actor:car manoeuvre:cut-in"));
}

#[test]
fn the_panel_tells_everything_and_follows_the_clock() {
    let mut bench = dangerous();
    bench.press("space g v");
    assert!(bench.model.screens.is_top::<VariantScreen>());
    let effect = &made(&bench).effect;
    let attacker = effect.main().obstacle;
    let obstacle = effect.scenario.obstacle(attacker).unwrap();
    let last = bench.model.clock.step();
    let panel = bench.frame(200, 60);
    for words in [
        format!("{} {attacker}", obstacle.kind),
        "search, seed 1, at most ".into(),
        format!("X collision with {attacker}"),
        format!("{} → 0", effect.lowest_before().unwrap()),
        "avoided with 0.0".into(),
        format!("step {last}: recorded → changed"),
        "apart".into(),
        "until you quit".into(),
    ] {
        assert!(panel.contains(&words), "{words}\n{panel}");
    }
    let steps = format!("{} checked", made(&bench).passed[0].steps);
    assert!(panel.contains(&steps), "{panel}");
    bench.press("left");
    let panel = bench.frame(200, 60);
    let words = format!("step {}: recorded → changed", last - 1);
    assert!(panel.contains(&words), "{panel}");
    bench.model.clock.go(made(&bench).effect.from);
    let panel = bench.frame(200, 60);
    assert!(panel.contains("as recorded until here"), "{panel}");
    assert!(panel.contains("apart      0"), "{panel}");
    bench.press("space g o");
    assert!(!shown(&bench).changed);
    assert!(
        bench
            .frame(200, 60)
            .contains("the original; Space g o the variant")
    );
    bench.press("space g v");
    assert!(bench.model.screens.is_empty());
}

#[test]
fn the_layer_can_be_switched_off() {
    let mut bench = dangerous();
    bench.model.toasts.clear();
    let recorded = format!("{} recorded", made(&bench).effect.main().obstacle);
    assert!(bench.frame(200, 60).contains(&recorded));
    bench.model.map.layers.variant = false;
    let without = bench.frame(200, 60);
    assert!(!without.contains(&recorded), "{without}");
    assert!(
        without.contains("attacker"),
        "who attacks is said in any case"
    );
}

#[test]
fn it_is_written_and_nothing_is_written_over() {
    let mut bench = dangerous();
    let folder = tempfile::tempdir().unwrap();
    bench.model.config.pictures = Some(folder.path().into());
    bench.perform("save-variant");
    let mut asks = bench
        .effects
        .iter()
        .rev()
        .filter_map(|effect| match effect.request() {
            Some(SaveVariant(made, folder)) => Some((made.clone(), folder.clone())),
            _ => None,
        });
    let (made, into) = asks.next().unwrap();
    assert_eq!(into.as_deref(), Some(folder.path()));
    let count = || std::fs::read_dir(folder.path()).unwrap().count();
    let words = write(&made, into.as_deref()).unwrap();
    let (first, opened) = (count(), bench.model.opened.as_ref().unwrap());
    let file = folder.path().join(format!("{}.xml", opened.name));
    assert!(words.starts_with(&file.display().to_string()), "{words}");
    // What was shown is what is written: answers about the one are about the other.
    let written = commonroad::read_file(&file).unwrap();
    assert_eq!(written.hash, opened.scenario.hash);
    assert_eq!(written.obstacles.len(), opened.scenario.obstacles.len());
    for ending in [".ego_trajectory.csv", ".solution.xml", ".json"] {
        let name = format!("{}{ending}", opened.name);
        assert!(words.contains(&name) && folder.path().join(name).exists());
    }
    let again = write(&made, into.as_deref()).unwrap();
    assert_ne!(again, words);
    assert_eq!(count(), 2 * first);
    bench.send(Msg::reply::<SaveVariant>((made.clone(), Ok(words))));
    bench.press("space g v");
    assert!(bench.frame(200, 60).contains("the variant is kept"));
    assert!(bench.model.generation.files(&made).is_some());
    let nowhere = folder.path().join("none");
    let why = write(&made, Some(&nowhere)).unwrap_err();
    assert!(why.contains("none") && why.contains("`pictures`"), "{why}");
}

#[test]
fn who_quits_with_a_variant_that_is_not_saved_is_asked_and_its_scenario_opens_anew() {
    let mut bench = dangerous();
    bench.model.recall.on = true;
    bench.press("space m g q");
    let quits = |bench: &Bench| bench.effects.iter().any(|e| matches!(e, Effect::Quit));
    assert!(!quits(&bench));
    let words = "1 variant is not saved; q again quits without it";
    assert_eq!(said(&bench), words);
    let (made, files) = (shown(&bench).made.clone(), "here.xml".to_string());
    bench.send(Msg::reply::<SaveVariant>((made, Ok(files))));
    bench.press("q");
    assert!(quits(&bench), "{}", said(&bench));
    let session = bench.model.recall.kept.as_ref().expect("it is kept");
    let opened = session.opened.as_ref().expect("a scenario is open");
    assert_eq!((opened.step, session.split_map), (None, false));
}

#[test]
fn a_variant_at_both_sizes() {
    for (columns, rows) in [(80, 24), (200, 60)] {
        let mut bench = open("rightturn");
        bench.send(Msg::Resize(columns, rows));
        bench.frame(columns, rows);
        bench.press("space g g");
        arrive(&mut bench);
        bench.model.toasts.clear();
        bench.press("tab");
        bench.model.map.layers.planner = false;
        let at = format!("at_{columns}_by_{rows}");
        insta::assert_snapshot!(format!("both_motions_{at}"), bench.frame(columns, rows));
        bench.press("space g v");
        insta::assert_snapshot!(format!("the_variant_{at}"), bench.frame(columns, rows));
    }
}

/// A scenario in which one obstacle alone reaches nothing with so few motions, and two do.
const SCENARIO: &str = "hardbraking";
const SEED: u64 = 9;

fn attacked_by_two() -> Bench {
    let mut bench = open(SCENARIO);
    bench.model.config.attackers = Some(2);
    let hash = bench.model.opened.as_ref().unwrap().scenario.hash;
    for _ in 1..SEED {
        bench.model.generation.next_seed(hash, None);
    }
    bench.press("space g g");
    assert!(said(&bench).contains("one obstacle or several"));
    let wish = asked(&bench).pop().unwrap().1;
    assert_eq!((wish.attackers, wish.seed), (2, SEED));
    arrive(&mut bench);
    assert_eq!(made(&bench).effect.attackers.len(), 2, "{}", said(&bench));
    bench
}

#[test]
fn the_panel_tells_what_each_does_and_what_comes_without_it() {
    let mut bench = attacked_by_two();
    let ids: Vec<i64> = made(&bench).effect.ids().collect();
    assert!(said(&bench).contains(&format!("variant: {} and {}, ", ids[0], ids[1])));
    bench.press("space g v");
    let panel = bench.frame(200, 120);
    assert!(panel.contains("attackers"), "{panel}");
    for id in ids {
        assert!(panel.contains(&format!("{id} at ")), "{panel}");
    }
    let all = &made(&bench).effect.attackers;
    assert!(all.iter().all(|one| one.without.is_some()));
    assert_eq!(panel.matches("up to step").count(), 2, "{panel}");
}

#[test]
fn the_map_and_pictures_draw_the_motions_of_both() {
    let mut bench = attacked_by_two();
    let ids: Vec<i64> = made(&bench).effect.ids().collect();
    bench
        .model
        .clock
        .go(made(&bench).change.until_step().unwrap());
    bench.frame(200, 60);
    let folder = tempfile::tempdir().unwrap();
    bench.model.config.pictures = Some(folder.path().into());
    bench.press("space o p");
    bench.type_text("svg");
    bench.press("enter");
    let Some(Effect::Picture(job)) = bench.effects.pop() else {
        panic!("no picture was asked for");
    };
    let path = save(&job, &Drawing::default().begin()).unwrap();
    let svg = std::fs::read_to_string(path).unwrap();
    for id in ids {
        assert!(svg.contains(&format!("obstacle {id} after step ")), "{svg}");
    }
}

/// A variant at its worst step, on a screen of that size.
fn shown_small(name: &str, columns: u16, rows: u16) -> Bench {
    let mut bench = open(name);
    bench.send(crate::message::Msg::Resize(columns, rows));
    bench.frame(columns, rows);
    bench.press("space g g");
    arrive(&mut bench);
    bench.model.toasts.clear();
    bench
}

#[test]
fn the_header_says_what_the_variant_leads_to_before_how_would_be_asked() {
    let mut bench = shown_small("rightturn", 80, 24);
    let Consequence::Collision(with) = made(&bench).effect.consequence else {
        panic!("{:?}", made(&bench).effect.consequence);
    };
    let name = bench.model.opened.as_ref().unwrap().name.clone();
    let header = |bench: &mut Bench, columns| {
        let frame = bench.frame(columns, 24);
        frame.lines().next().unwrap().to_string()
    };
    let words = format!("variant · collision with {} · {name}", with.with);
    let narrow = header(&mut bench, 80);
    assert!(narrow.contains(&words), "{narrow}");
    assert!(header(&mut bench, 200).contains("cp+cot+icl"));
    bench.press("space g o");
    let original = header(&mut bench, 80);
    assert!(
        original.contains("original · goal reached · "),
        "{original}"
    );
}

#[test]
fn the_attacker_is_named_however_little_room_there_is() {
    let mut bench = shown_small("rightturn", 80, 24);
    let attacker = made(&bench).effect.main().obstacle;
    // The list in front leaves few rows to the map; farther away all bodies share a few cells.
    for focus in ["", "tab"] {
        bench.press(focus);
        for _ in 0..6 {
            let frame = bench.frame(80, 24);
            let map: Vec<&str> = frame.lines().skip(1).collect();
            let label = format!("X {attacker}");
            let named = |line: &&str| line.contains(&label);
            assert!(map.iter().any(named), "{frame}");
            bench.perform("zoom-out");
        }
    }
}

#[test]
fn the_plot_says_both_scores() {
    let bench = shown_small("rightturn", 80, 24);
    let scores = "⠒⠒after 0 · ⠂⠀⠂before ";
    let frame = bench.frame(80, 24);
    assert!(frame.contains(&format!(" risk · {scores}")), "{frame}");
    let wide = bench.frame(200, 60);
    let title = format!("attacker's risk now, 0 = collision · {scores}");
    assert!(wide.contains(&title), "{wide}");
}

#[test]
fn who_has_a_variant_needs_no_way_to_a_first_verdict() {
    let mut bench = open("rightturn");
    bench.model.recall.hint = true;
    assert!(bench.frame(80, 24).contains("p play"));
    bench.press("space g g");
    arrive(&mut bench);
    for (columns, rows) in [(80, 24), (200, 60)] {
        let frame = bench.frame(columns, rows);
        assert!(
            !frame.contains("three keys") && !frame.contains("p play  m"),
            "{frame}"
        );
    }
}

#[test]
fn the_strip_names_three_drives_and_marks_the_contact() {
    let mut bench = dangerous();
    bench.press("space g v");
    let strip = bench.model.strip().expect("a variant has a strip");
    let contact = strip.ego.opened.contact().expect("a collision");
    assert_eq!(contact.step, strip.ego.step);
    let when = strip.ego.when();
    let contact = format!(
        "X contact {:.1} s",
        contact.step as f64 * strip.ego.opened.scenario.dt()
    );
    let turned = format!("{} X", contact.trim_start_matches("X "));
    let delay = made(&bench).avoidability.latest().map(|(delay, _)| delay);
    let attacker = strip.other;
    let title = |name: &str, ending: &str, moment: &crate::model::Moment<'_>| {
        let series = moment.opened.series.as_ref().unwrap();
        let (id, gap) = series.most_dangerous_at("distance", moment.step).unwrap();
        format!(
            "┌ {name} · {ending} · {gap:.1} m to {id} · {} ",
            moment.when()
        )
    };
    let mut titles = vec![
        title(
            "original, planned ego",
            "no contact",
            strip.original.as_ref().unwrap(),
        ),
        title("attack", "X collision", &strip.ego),
    ];
    if let Some(survived) = &strip.driver {
        let name = format!("ideal driver, reaction {:.1} s", delay.unwrap());
        titles.push(title(&name, "no contact", survived));
    }
    for (columns, rows) in [(120, 40), (200, 60)] {
        let frame = bench.frame(columns, rows);
        let lines: Vec<&str> = frame.lines().collect();
        let place = |words: &str| lines.iter().position(|line| line.contains(words));
        // On a narrow screen the end of a title is left out.
        let shown = |title: &String| match columns {
            120 => title
                .replace(&format!(" · {when}"), "")
                .trim_end()
                .to_string(),
            _ => title.clone(),
        };
        let places: Vec<_> = titles.iter().map(|title| place(&shown(title))).collect();
        assert!(places.iter().all(Option::is_some), "{titles:?}\n{frame}");
        assert!(places.is_sorted(), "one below the other");
        let rows: Vec<usize> = { places.windows(2) }
            .filter_map(|pair| Some(pair[1]? - pair[0]?))
            .collect();
        assert!(rows.iter().all(|each| *each == rows[0]), "{rows:?}");
        let gaps = place(&format!("┌ gap to {attacker}")).unwrap();
        let goal = lines[..gaps].iter().find(|line| {
            let map = line.split('┃').next();
            map.is_some_and(|map| map.contains("goal"))
        });
        assert_eq!(goal, None, "no map names the goal");
        assert!(lines[gaps].contains("⠒⠒ attack"), "{frame}");
        let below = lines[gaps + 1..].join("\n");
        assert!(
            below.contains(&contact) || below.contains(&turned),
            "{frame}"
        );
        assert!(
            below.contains("original"),
            "a line is named at its end\n{frame}"
        );
        let rows_of_gaps = lines.len() - gaps - 1;
        assert!(
            rows_of_gaps * 100 / lines.len() >= 25,
            "{rows_of_gaps}\n{frame}"
        );
    }
    let frame = bench.frame(100, 30);
    assert!(
        frame.contains(&format!("┌ gap to {attacker} · {contact} ")),
        "low, the title names the contact\n{frame}"
    );
}

#[test]
fn low_maps_of_the_strip_show_the_contact_whole_and_large() {
    let mut bench = dangerous();
    bench.press("space g v");
    let strip = bench.model.strip().expect("a variant has a strip");
    let attack = &strip.ego;
    for (columns, rows) in [(48_u16, 5_u16), (60, 8), (144, 12)] {
        let camera = bench.model.camera_of_strip((columns, rows), &strip);
        assert!(camera.cell < 1.0, "{columns}×{rows}: {}", camera.cell);
        let frame = camera.frame(attack.ego());
        for on in [On::Ego, On::Obstacle(strip.other)] {
            let body = attack.opened.body_of(on, attack.step).unwrap();
            for corner in body.outlines().concat() {
                let at = frame.to_local(&corner);
                let inside = at.x.abs() * 2.0 < camera.row() * f64::from(rows)
                    && at.y.abs() * 2.0 < camera.cell * f64::from(columns);
                assert!(inside, "{on:?} in {columns}×{rows}");
            }
        }
    }
}

#[test]
fn help_over_the_strip_begins_with_its_keys() {
    let mut bench = dangerous();
    bench.press("space g v ?");
    let frame = bench.frame(200, 60);
    let lines: Vec<&str> = frame.lines().collect();
    let here = lines
        .iter()
        .position(|line| line.contains("here: in a window"));
    let here = here.unwrap_or_else(|| panic!("{frame}"));
    let always = lines
        .iter()
        .position(|line| line.contains("always"))
        .unwrap();
    for words in [
        "Space g o",
        "Space m g",
        "Space g s",
        "original or variant",
        "driver beside",
    ] {
        let keys = &lines[here..always];
        assert!(
            keys.iter().any(|line| line.contains(words)),
            "{words}\n{frame}"
        );
    }
    bench.type_text("driver beside");
    let found = bench.frame(200, 60);
    assert!(found.contains("Space m g"), "{found}");
}

#[test]
fn the_certificate_is_told_in_plain_words() {
    let mut bench = dangerous();
    let Some((delay, way)) = made(&bench)
        .avoidability
        .latest()
        .map(|(d, way)| (d, way.clone()))
    else {
        return;
    };
    let effect = &made(&bench).effect;
    let dt = made(&bench).closed.driver().dt();
    let (departs, contact) = (way.reaction, effect.contact.unwrap().step);
    let left = (contact - departs) as f64 * dt;
    let driver = made(&bench).ideal_driver.clone().unwrap();
    bench.press("space g v");
    // Words are wrapped.
    let frame = bench.frame(200, 100);
    let panel: Vec<String> = { frame.lines() }
        .filter_map(|line| line.rsplit_once('┃').map(|(line, _)| line.to_string()))
        .filter_map(|line| line.rsplit_once('┃').map(|(_, words)| words.to_string()))
        .collect();
    let words = panel.join(" ");
    let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
    for said in [
        "an ideal driver avoids it".into(),
        format!("at {:.1} s at the latest, ", departs as f64 * dt),
        format!("and {left:.1} s before the contact"),
        format!("peak {:.1} m/s²", driver.max_acceleration.unwrap()),
        "ideal: it knows all motions to come".into(),
        format!("{delay:.1} s"),
        "physically valid: it passed the gate".into(),
        "(0 = collision)".into(),
    ] {
        assert!(words.contains(&said), "{said}\n{words}");
    }
}

#[test]
fn a_search_covers_no_pane_and_says_which_keys_cancel_it() {
    let mut bench = open("rightturn");
    bench.press("space g g");
    let frame = bench.frame(80, 24);
    let lines: Vec<&str> = frame.lines().collect();
    assert!(
        lines[21].starts_with('└') && lines[21].ends_with('┘'),
        "{frame}"
    );
    assert!(lines[22].contains("searching for an attack"), "{frame}");
    let last = |frame: &str| frame.lines().last().unwrap().to_string();
    assert!(last(&frame).starts_with(" Esc Esc cancel · "), "{frame}");
    bench.press("esc");
    let frame = bench.frame(80, 24);
    assert!(last(&frame).starts_with(" Esc again cancels · "), "{frame}");
}

#[test]
fn without_room_for_three_maps_the_gaps_stand_above_the_text() {
    let mut bench = dangerous();
    bench.model.toasts.clear();
    bench.press("space g v");
    let least = super::super::features::drivers::strip::least_screen();
    let (columns, rows) = least.split_once('×').unwrap();
    let (columns, rows) = (columns.parse().unwrap(), rows.parse().unwrap());
    let words = format!("a {least} terminal shows three maps");
    let attacker = bench.model.strip().unwrap().other;
    let gaps = format!("┌ gap to {attacker}");
    for (size, maps) in [
        ((80, 24), false),
        ((columns - 1, rows), false),
        ((columns, rows), true),
    ] {
        let frame = bench.frame(size.0, size.1);
        assert_eq!(frame.contains("┌ original"), maps, "{frame}");
        assert_eq!(frame.contains(&words), !maps, "{frame}");
        assert!(
            frame.contains(&gaps) && frame.contains("outcome, computed"),
            "{frame}"
        );
    }
}
