//! Values of measures, and their plot.

use std::sync::Arc;

use crate::features::scenarios::request::{Rank, Survey};
use crate::features::values::{MeasureAll, ReadThresholds, UseThresholds};
use crate::loaded::{Measured, Ranked};
use crate::message::{Effect, Msg};
use crate::model::MeasureId;
use crate::tests::bench::{Bench, planned};
use nearmiss_drive::planner::Forecast;
use nearmiss_scene::metrics::{LIMITS, MEASURES, SCENE_MEASURES, Thresholds};
use nearmiss_scene::scenario::{Sample, Scene, Track};

/// The first scenario shortly before its contact.
fn looking() -> Bench {
    let mut bench = Bench::bundled();
    bench.press("x left left left space o v");
    bench
}

fn own() -> Arc<Thresholds> {
    let text = "[[threshold]]\nmeasure = \"ttc\"\nname = \"critical\"\nvalue = 0.2\n\
                [[level]]\nscore = 4\ndistance = 80\ntime = 80\n[[limit]]\nname = \"tau\"\nvalue = 1.1\n";
    Arc::new(Thresholds::read(text, "mine/thresholds.toml").unwrap())
}

/// All that the window says, page by page.
fn pages(bench: &mut Bench, columns: u16, rows: u16) -> String {
    let mut seen = String::new();
    for _ in 0..30 {
        seen.push_str(&bench.frame(columns, rows));
        bench.press("pagedown");
    }
    seen
}

#[test]
fn values_at_80_by_24() {
    insta::assert_snapshot!(looking().frame(80, 24));
}

#[test]
fn values_at_200_by_60() {
    insta::assert_snapshot!(looking().frame(200, 60));
}

#[test]
fn every_measure_and_every_limit_is_there() {
    for (columns, rows) in [(80, 24), (200, 60)] {
        let seen = pages(&mut looking(), columns, rows);
        let measures = MEASURES.iter().map(|m| m.id);
        let scene = SCENE_MEASURES.iter().map(|m| m.id);
        for id in measures.chain(scene).chain(LIMITS.iter().map(|l| l.id)) {
            let line = seen
                .lines()
                .any(|l| l.split([' ', '┃']).any(|word| word == id));
            assert!(line, "{id} at {columns}×{rows}: {seen}");
        }
        assert!(seen.contains("shipped values") && seen.contains("van der Horst"));
    }
}

#[test]
fn steps_and_obstacles_can_be_changed_while_it_is_open() {
    let mut bench = looking();
    let line = |bench: &Bench, id: &str| {
        let frame = bench.frame(120, 40);
        let mut lines = frame.lines().filter(|l| l.contains(&format!(" {id} ")));
        lines.next().unwrap_or_default().to_string()
    };
    let (step, ttc) = (bench.model.clock.step(), line(&bench, "ttc"));
    assert!(
        ttc.contains("! ttc") && ttc.contains("critical 1.50 s"),
        "{ttc}"
    );
    bench.press("right");
    assert_eq!(bench.model.clock.step(), step + 1);
    assert_ne!(line(&bench, "ttc"), ttc);
    bench.press("left");
    assert_eq!(line(&bench, "ttc"), ttc);
    let picked = bench.model.picked.unwrap();
    bench.press("n");
    let next = bench.model.picked.unwrap();
    assert_ne!(next, picked);
    assert!(bench.frame(120, 40).contains(&format!(" {next} at ")));
    assert_ne!(line(&bench, "distance"), "");
    assert_eq!(bench.model.screens.iter().count(), 1);
    bench.press("home");
    assert!(!line(&bench, "ttc").contains("! ttc"), "far away at first");
    bench.press("esc");
    assert!(bench.model.screens.is_empty());
}

#[test]
fn values_are_asked_for_only_while_they_are_shown_and_old_ones_are_dropped() {
    let mut bench = Bench::bundled();
    bench.press("n n right");
    assert!(bench.model.values.asked.is_none());
    bench.press("space o v");
    let (id, _) = bench.model.values.asked.unwrap();
    bench.press("right left home");
    assert_eq!(
        bench.model.values.asked.unwrap().0,
        id,
        "nothing is measured twice"
    );
    bench.press("n");
    let known = bench
        .model
        .values
        .for_obstacle(bench.model.picked)
        .is_some();
    assert!(known);
    let scene = bench.model.opened.as_ref().unwrap().scene.clone().unwrap();
    let late = Measured::new(&scene, None, Thresholds::shipped());
    bench.send(Msg::reply::<MeasureAll>((id, Box::new(late))));
    assert!(
        bench
            .model
            .values
            .for_obstacle(bench.model.picked)
            .is_some(),
        "too late"
    );
    bench.model.values.found = None;
    assert!(bench.frame(80, 24).contains("computing"));
    let unasked = Measured::new(&scene, None, Thresholds::shipped());
    bench.send(Msg::reply::<MeasureAll>((MeasureId(0), Box::new(unasked))));
    assert!(bench.model.values.found.is_none(), "never asked for");
}

#[test]
fn thresholds_of_the_users_change_plot_list_and_judge() {
    let mut bench = Bench::bundled();
    let risk = |bench: &Bench| {
        bench
            .model
            .opened
            .as_ref()
            .unwrap()
            .headline
            .as_ref()
            .unwrap()
            .clone()
    };
    let scores = |bench: &Bench| {
        let reference = bench.model.answers.reference.as_ref().unwrap();
        reference
            .verdict
            .obstacles
            .iter()
            .map(|o| u32::from(o.risk_score))
            .sum::<u32>()
    };
    let before = (risk(&bench), scores(&bench), bench.frame(200, 60));
    let row = |bench: &Bench| {
        let series = bench.model.plot.series.as_ref().unwrap();
        let rows = series
            .obstacles()
            .iter()
            .flat_map(|&id| series.row("risk", id).to_vec());
        rows.collect::<Vec<_>>()
    };
    let plotted = row(&bench);
    bench.press("space l s");
    bench.type_text("drac");
    bench.press("enter");
    bench.press(":");
    bench.type_text("read-thresholds");
    bench.press("enter");
    assert!(
        bench
            .effects
            .iter()
            .any(|e| matches!(e.request(), Some(ReadThresholds)))
    );
    bench.effects.clear();
    bench.send(Msg::reply::<ReadThresholds>(Ok(own())));
    assert_eq!(risk(&bench).distance, before.0.distance);
    assert!(scores(&bench) < before.1, "wider levels score lower");
    assert_ne!(row(&bench), plotted, "the plot follows");
    let anew = |wanted: fn(&Effect) -> bool| bench.effects.iter().any(wanted);
    assert!(anew(
        |e| matches!(e.request(), Some(UseThresholds(t)) if t.file().is_some())
    ));
    assert!(anew(
        |e| matches!(e.request(), Some(Survey::All(list)) if list.len() == 8)
    ));
    assert!(anew(
        |e| matches!(e.request(), Some(Rank::All("drac", list)) if list.len() == 8)
    ));
    let question = bench.model.prompt.question.as_ref().unwrap();
    assert!(question.prompt.user.contains("80") || question.prompt.system.contains("80"));
    bench.press("space p m");
    bench.type_text("ttc");
    bench.press("enter");
    assert!(bench.frame(200, 60).contains("critical 0.20 s (yours)"));
    bench.press("space o v");
    let seen = pages(&mut bench, 120, 40);
    for words in [
        "mine/thresholds.toml",
        "* ttc critical",
        "* 4 low",
        "80 m, 80 s",
        "* tau",
        "1.10 s",
    ] {
        assert!(seen.contains(words), "{words}: {seen}");
    }
    bench.press("esc");
    // What cannot be used changes nothing and is said.
    bench.send(Msg::reply::<ReadThresholds>(Err("mine.toml:3: no".into())));
    assert_eq!(bench.model.thresholds.file(), Some("mine/thresholds.toml"));
    assert!(
        bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("mine.toml:3")
    );
    bench.send(Msg::reply::<ReadThresholds>(Ok(Arc::new(
        Thresholds::shipped().clone(),
    ))));
    assert_eq!((risk(&bench), scores(&bench)), (before.0, before.1));
}

#[test]
fn an_obstacle_that_is_the_ego_stays_it_with_other_thresholds() {
    let mut bench = Bench::bundled();
    bench.press("n space e t");
    let taken = bench.model.scene().unwrap().ego.id;
    bench.send(Msg::reply::<ReadThresholds>(Ok(own())));
    assert_eq!(bench.model.scene().unwrap().ego.id, taken);
}

#[test]
fn without_an_ego_only_thresholds_are_shown() {
    let mut bench = Bench::empty();
    bench.press("space o v");
    let frame = bench.frame(100, 30);
    assert!(
        frame.contains("no values: no scenario is open") && frame.contains("thresholds"),
        "{frame}"
    );
}

#[test]
fn nothing_is_cut_and_the_keys_that_work_are_told() {
    for (columns, rows) in [(80, 24), (120, 40), (200, 60)] {
        let mut bench = looking();
        let keys = bench.frame(columns, rows);
        let keys = keys.lines().last().unwrap();
        assert!(
            keys.contains("←→ step") && keys.contains("n obstacle") && !keys.contains("choose"),
            "{keys}"
        );
        let seen = pages(&mut bench, columns, rows);
        let inside = seen.lines().filter_map(|line| line.split('┃').nth(1));
        for line in inside {
            assert!(!line.contains('…'), "{columns}×{rows}: {line}");
        }
    }
    let mut bench = Bench::bundled();
    for keys in ["?", "space o i"] {
        bench.press(keys);
        let frame = bench.frame(80, 24);
        let last = frame.lines().last().unwrap();
        assert!(
            last.contains("↑↓ scroll") && !last.contains("choose"),
            "{last}"
        );
        bench.press("esc");
    }
}

#[test]
fn thresholds_read_again_keep_what_was_picked_and_marked() {
    let mut bench = Bench::bundled();
    bench.press("space p o n space p o right right");
    let kept = |bench: &Bench| {
        let model = &bench.model;
        (model.picked, model.plot.marked.clone(), model.clock.step())
    };
    let before = kept(&bench);
    assert_eq!(before.1.len(), 2);
    bench.send(Msg::reply::<ReadThresholds>(Ok(own())));
    assert_eq!(kept(&bench), before);
}

#[test]
fn any_measure_is_plotted_for_chosen_obstacles() {
    let mut bench = Bench::bundled();
    bench.press("space p m");
    bench.type_text("ttc");
    bench.press("enter");
    assert_eq!(bench.model.plot.measure.id, "ttc");
    let picked = bench.model.picked.unwrap();
    // The picked one has dashes, marked ones have others, all together have none.
    let frame = bench.frame(200, 60);
    assert!(frame.contains(&format!("⠒⠒⠀⠀⠒⠒ {picked}")), "{frame}");
    bench.press("space p o n space p o n");
    assert_eq!(bench.model.plot.marked.len(), 2);
    assert_eq!(bench.model.plot.marked[0], picked);
    let frame = bench.frame(200, 60);
    for words in [
        "· picked",
        "critical 1.50 s",
        &format!("⠂⠀⠂ {picked}"),
        "⠒⠒ min",
    ] {
        assert!(frame.contains(words), "{words}: {frame}");
    }
    bench.press("shift-n space p o");
    assert_eq!(bench.model.plot.marked.len(), 1);
    bench.press("down");
    assert!(bench.model.plot.marked.is_empty(), "of another scenario");
    assert!(bench.model.plot.series.is_some());
}

fn valued(value: Option<f64>) -> Ranked {
    Ranked {
        value,
        stand_in: None,
    }
}

#[test]
fn the_list_is_sorted_by_a_measure() {
    let mut bench = Bench::bundled();
    let selected = bench.model.list.current();
    bench.press("space l s");
    bench.type_text("headway");
    bench.press("enter");
    let asked = bench.effects.iter().find_map(|e| match e.request() {
        Some(Rank::All(measure, entries)) => Some((*measure, entries.len())),
        _ => None,
    });
    assert_eq!(asked, Some(("headway", 8)));
    assert!(bench.frame(200, 60).contains("by headway, m"));
    for (place, value) in [(0, Some(3.0)), (5, Some(0.25)), (2, None)] {
        bench.send(Msg::reply::<Rank>(("headway", place, valued(value))));
    }
    bench.send(Msg::reply::<Rank>(("ttc", 1, valued(Some(0.0)))));
    assert_eq!(
        bench.model.list.visible[..2],
        [5, 0],
        "what is not known comes last"
    );
    assert_eq!(bench.model.list.current(), selected);
    assert!(bench.frame(200, 60).contains("0.25 "));
    bench.press("space l s enter");
    assert_eq!(bench.model.list.visible[..3], [0, 1, 2]);
}

#[test]
fn measures_to_choose_from_are_there_whole() {
    for key in ["space p m", "space l s"] {
        let mut bench = Bench::bundled();
        bench.press(key);
        let frame = bench.frame(200, 60);
        let inside = frame.lines().filter_map(|line| line.split('┃').nth(1));
        for line in inside {
            assert!(!line.contains('…'), "{line}");
        }
        // In a small window, the selected one is there whole below the list.
        bench.type_text("rss_long_margin");
        let frame = bench.frame(80, 24);
        let inside = frame.lines().filter_map(|line| line.split('┃').nth(1));
        let words: Vec<&str> = inside.map(str::trim).collect();
        let words = words.join(" ");
        let measure = nearmiss_scene::metrics::measure("rss_long_margin").unwrap();
        assert!(words.contains(measure.source), "{frame}");
    }
}

/// What is inside the plot's frame, its borders included.
fn plotted(bench: &Bench, columns: u16, rows: u16) -> String {
    let frame = bench.frame(columns, rows);
    let from = frame
        .lines()
        .position(|l| l.contains(&format!("┌ {}", bench.model.plot.measure.id)));
    let lines: Vec<&str> = frame.lines().skip(from.unwrap()).collect();
    let right = |line: &&str| {
        line.chars()
            .skip(usize::from(columns) / 2)
            .collect::<String>()
    };
    lines.iter().map(right).collect::<Vec<_>>().join("\n")
}

#[test]
fn axes_have_round_ends_and_units_and_marks_have_names() {
    let mut bench = Bench::bundled();
    bench.press("space p m");
    bench.type_text("distance");
    bench.press("enter space p o n space p o n");
    for (columns, rows) in [(80, 24), (120, 40), (200, 60)] {
        let plot = plotted(&bench, columns, rows);
        assert!(
            (plot.contains(" s ") || plot.contains(" s│")) && plot.contains(" m┤"),
            "{plot}"
        );
        for id in &bench.model.plot.marked {
            assert!(
                // The picked one has dashes, the marked ones have dots and others.
                ["⠂", "⠐⠀", "⠐"]
                    .iter()
                    .any(|sign| plot.contains(&format!("{sign} {id}"))),
                "{id} at {columns}×{rows}: {plot}"
            );
        }
        let numbers = plot.lines().filter(|l| l.contains('┤')).count();
        assert!((2..=6).contains(&numbers), "{plot}");
        let title = plot.lines().next().unwrap();
        assert!(title.ends_with('┐') && !title.contains("· ┐"), "{title}");
    }
}

#[test]
fn a_threshold_that_is_far_away_is_an_arrow_with_its_value() {
    let mut bench = Bench::bundled();
    bench.press("space p m");
    bench.type_text("ttc");
    bench.press("enter");
    assert_eq!(bench.model.plot.measure.id, "ttc");
    let text = "[[threshold]]\nmeasure = \"ttc\"\nname = \"far\"\nvalue = 900\n";
    let far = nearmiss_scene::metrics::Thresholds::read(text, "mine.toml").unwrap();
    bench.send(Msg::reply::<ReadThresholds>(Ok(std::sync::Arc::new(far))));
    for (columns, rows) in [(160, 45), (200, 60)] {
        let plot = plotted(&bench, columns, rows);
        assert!(plot.contains("↑ ") && plot.contains("far 900 s"), "{plot}");
    }
}

#[test]
fn a_drive_too_short_to_be_plotted_is_told_in_words() {
    let mut bench = Bench::bundled();
    let entry = bench.model.list.rows[0].entry.clone();
    let mut opened = planned(&entry, Forecast::Lane).unwrap();
    let mut scene = Scene::clone(opened.scene.as_deref().unwrap());
    let motions = scene.ego.track.iter().take(3);
    let samples = motions.map(|(step, motion)| Sample {
        step,
        position: motion.pose.position,
        heading: Some(motion.pose.heading),
        velocity: Some(motion.velocity),
        acceleration: Some(motion.acceleration),
    });
    scene.ego.track = Track::new(samples.collect(), 0.1, None);
    opened.scene = Some(Arc::new(scene));
    bench.model.opened = Some(Box::new(opened));
    let frame = bench.frame(120, 40);
    assert!(frame.contains("the drive ends after 0.2 s: "), "{frame}");
}

#[test]
fn risk_scores_are_steps_with_six_numbers_and_events() {
    let mut bench = Bench::bundled();
    bench.press("x");
    assert_eq!(bench.model.plot.measure.id, "risk");
    for (columns, rows) in [(120, 40), (200, 60), (300, 100)] {
        let plot = plotted(&bench, columns, rows);
        let number = |line: &str| line.split_once('┤')?.0.chars().last();
        let numbers: Vec<(usize, char)> = plot
            .lines()
            .enumerate()
            .filter_map(|(y, line)| Some((y, number(line)?)))
            .collect();
        let words: String = numbers.iter().map(|(_, number)| number).collect();
        assert_eq!(words, "543210", "{plot}");
        let gaps: Vec<usize> = numbers
            .windows(2)
            .map(|pair| pair[1].0 - pair[0].0)
            .collect();
        assert!(gaps.iter().all(|gap| *gap == gaps[0]), "{plot}");
        // The contact, and the window that is judged.
        assert!(
            plot.contains('X') && plot.contains('[') && plot.contains(']'),
            "{plot}"
        );
    }
    assert!(
        plotted(&bench, 200, 60).contains("X contact")
            || plotted(&bench, 200, 60).contains("contact X")
    );
}
