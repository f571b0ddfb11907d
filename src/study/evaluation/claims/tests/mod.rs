//! Tests on texts in several styles, about a bundled scenario: claims, obstacles, times relative to the end of the window.
#![allow(clippy::unwrap_used)]

mod forms;
mod language;
mod prose;
mod random;
mod recorded;
mod unread;
mod words;

use nearmiss_formats::bundled;
use nearmiss_scene::metrics::{Encounter, Thresholds};

use super::*;

fn scene() -> Scene {
    let all = bundled();
    let entry = all
        .iter()
        .find(|e| e.name.starts_with("ZAM_CutIn"))
        .unwrap();
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    Scene::new(scenario, ego)
}

/// Two obstacles that are there at every step of the window, and the window.
fn cast(scene: &Scene) -> (i64, i64, (i64, i64)) {
    let window = (scene.last_step() - 9, scene.last_step());
    let mut there = scene
        .participants()
        .filter(|p| (window.0..=window.1).all(|step| Encounter::at(scene, p, step).is_some()));
    let first = there.next().unwrap().obstacle.id;
    (first, there.next().unwrap().obstacle.id, window)
}

fn relation(scene: &Scene, id: i64, step: i64) -> nearmiss_scene::metrics::Relation {
    let who = scene.participants().find(|p| p.obstacle.id == id).unwrap();
    Encounter::at(scene, &who, step).unwrap().relation()
}

/// Sentences of which nothing was understood, bytes.
fn not_understood(text: &str, subject: &Subject<'_>) -> Vec<Range<usize>> {
    let all = sentences(text, subject).into_iter();
    all.filter(|one| one.claims.is_empty())
        .map(|one| one.span)
        .collect()
}

/// What is found: whom, what, the words, the step named.
fn found(text: &str) -> Vec<(i64, Quantity, String, Option<i64>)> {
    let scene = scene();
    let subject = Subject::new(&scene, TimeOrigin::Recording, None);
    let claims = find(text, &subject).into_iter();
    claims
        .map(|c| (c.obstacle, c.quantity, text[c.span].to_string(), c.step))
        .collect()
}

fn brief(text: &str) -> Vec<String> {
    let name = |(id, quantity, words, step): (i64, Quantity, String, Option<i64>)| {
        let at = step.map_or(String::new(), |s| format!(" @{s}"));
        format!("{id} {}: {words}{at}", quantity.name())
    };
    found(text).into_iter().map(name).collect()
}

fn ids() -> (i64, i64) {
    let scene = scene();
    let (a, b, _) = cast(&scene);
    (a, b)
}

#[test]
fn prose() {
    let (a, b) = ids();
    let text = format!(
        "At time step 14, obstacle {a} is directly in front of the ego with a longitudinal distance of 3.20 m and a \
         TTC of 1.2 s. Its relative velocity is longitudinal -2.5 m/s, lateral 0.1 m/s. Obstacle {b} moves at a speed \
         of 8.1 m/s.\n\nThe distance is 4 m."
    );
    assert_eq!(
        brief(&text),
        [
            format!("{a} direction: in front of the ego @14"),
            format!("{a} gap longitudinal: 3.20 m @14"),
            format!("{a} TTC: 1.2 s @14"),
            format!("{a} relative velocity longitudinal: -2.5 m/s"),
            format!("{a} relative velocity lateral: 0.1 m/s"),
            format!("{b} speed: 8.1 m/s"),
        ],
        "after the blank line no subject is left"
    );
}

#[test]
fn markdown_lists_under_headings() {
    let (a, b) = ids();
    let text = format!(
        "### Analysis for the most recent timestep (1.0 seconds)\n\
         #### Obstacle {a}:\n\
         - **Position**: Rear-left\n\
         - **Adjusted Distances**: Longitudinal = -4.12 m, Lateral = 1.88 m\n\
         - **TTC**:\n  - Longitudinal: 12.84m / 2.58 m/s = **4.98s** (Low Risk)\n\
         1. **Obstacle {b}.0**:\n   - **TTC**: Estimated ~2.5s (distance ~20m)\n\
         ### Conclusion\n- The distance is 1 m."
    );
    assert_eq!(
        brief(&text),
        [
            format!("{a} direction: rear-left @10").replace("rear", "Rear"),
            format!("{a} gap longitudinal: -4.12 m @10"),
            format!("{a} gap lateral: 1.88 m @10"),
            format!("{a} gap longitudinal: 12.84m @10"),
            format!("{a} arithmetic: 12.84m / 2.58 m/s @10"),
            format!("{a} relative velocity longitudinal: 2.58 m/s @10"),
            format!("{a} TTC longitudinal: 4.98s @10"),
            format!("{a} risk score: Low Risk @10"),
            format!("{b} TTC: 2.5s @10"),
            format!("{b} distance: 20m @10"),
        ]
    );
}

#[test]
fn an_axis_may_stand_behind_its_number() {
    let (a, _) = ids();
    assert_eq!(
        brief(&format!(
            "- **Obstacle {a}:** Front-left, 1.07m longitudinal, 16.82m lateral distance."
        )),
        [
            format!("{a} direction: Front-left"),
            format!("{a} gap longitudinal: 1.07m"),
            format!("{a} gap lateral: 16.82m"),
        ]
    );
    assert_eq!(
        brief(&format!(
            "Obstacle {a}: distance ~1.5m (longitudinal), ~15.1m (lateral)"
        )),
        [
            format!("{a} gap longitudinal: 1.5m"),
            format!("{a} gap lateral: 15.1m"),
        ]
    );
}

#[test]
fn tables_and_json() {
    let (a, b) = ids();
    let table = format!(
        "| Obstacle | Distance (m) | TTC | Risk |\n|---|---|---|---|\n| {a} | 3.2 | 1.5 s | 2 |\n| {b} | 7.25 | - | 4 |"
    );
    assert_eq!(
        brief(&table),
        [
            format!("{a} distance: 3.2"),
            format!("{a} TTC: 1.5 s"),
            format!("{a} risk score: 2"),
            format!("{b} distance: 7.25"),
            format!("{b} risk score: 4"),
        ]
    );
    let json = format!(
        r#"{{"collision":true,"obstacles":[{{"id":{a},"risk_score":0,"reason":"lateral gap 0.5 m"}},{{"id":{b},"reason":"longitudinal distance of 9.0 m"}}],"justification":"the gap is 1 m"}}"#
    );
    assert_eq!(
        brief(&json),
        [
            format!("{a} risk score: 0"),
            format!("{a} gap lateral: 0.5 m"),
            format!("{b} gap longitudinal: 9.0 m"),
        ]
    );
}

#[test]
fn what_is_not_plain_is_left_alone() {
    let (a, b) = ids();
    for text in [
        format!("Obstacle {a} and obstacle {b} have a distance of 3 m."),
        format!("If obstacle {a} brakes, its TTC would be 2 s."),
        format!("Obstacle {a} is 4.5 m long."),
        format!("Further laterally (-19.79 m) than {a}, it closes in."),
        format!("Obstacle {a} is at a distance of -5 m."),
        "Obstacle 99999 has a distance of 3 m.".to_string(),
        "The distance is 3 m.".to_string(),
        format!("Obstacle {a}: minimal distance change (~0.25 m)."),
    ] {
        assert_eq!(brief(&text), Vec::<String>::new(), "{text}");
    }
    for (text, claim) in [
        (
            format!("The TTC of obstacle {a} is less than 1 s."),
            "TTC: 1 s",
        ),
        (
            format!("Obstacle {a} has a distance of 2-3 m."),
            "distance: 3 m",
        ),
        (
            format!("Obstacle {a}: At that time the longitudinal distance was 3 m."),
            "gap longitudinal: 3 m",
        ),
        (
            format!("There is no collision at step 14 with obstacle {a}."),
            "contact: collision @14",
        ),
        (
            format!("Obstacle {a} is initially behind the ego vehicle."),
            "direction: behind the ego vehicle",
        ),
    ] {
        assert_eq!(brief(&text), [format!("{a} {claim}")], "{text}");
    }
}

#[test]
fn claims_are_held_against_the_geometry() {
    let scene = scene();
    let (a, _, window) = cast(&scene);
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some(window));
    let now = relation(&scene, a, window.1);
    let speed = |step| {
        let who = scene.participants().find(|p| p.obstacle.id == a).unwrap();
        who.at(step).unwrap().velocity
    };
    let one = |text: String| {
        let mut all = checked(&text, &subject);
        assert_eq!(all.len(), 1, "{text}: {all:?}");
        all.remove(0)
    };
    let right = one(format!(
        "Obstacle {a}: longitudinal gap {:.2} m",
        now.gap_long
    ));
    assert_eq!(
        (right.judgement, right.basis, right.step),
        (Judgement::Right, ClaimBasis::Exact, window.1)
    );
    let wrong = one(format!(
        "Obstacle {a}: longitudinal gap {:.2} m",
        now.gap_long + 100.0
    ));
    assert_eq!(wrong.judgement, Judgement::Wrong);
    assert!((wrong.truth.unwrap() - now.gap_long).abs() < 1e-9);
    let line = wrong.line();
    let side = if now.gap_long < 0.0 { " behind" } else { "" };
    assert!(
        line.contains(&format!(
            "actual {:.2} m{side} (gap longitudinal, step {})",
            now.gap_long.abs(),
            window.1
        )),
        "{line}"
    );
    let named = one(format!(
        "At time step {} obstacle {a} has a speed of {:.1} m/s",
        window.0,
        speed(window.0)
    ));
    assert_eq!((named.judgement, named.step), (Judgement::Right, window.0));
    let centre = {
        let who = scene.participants().find(|p| p.obstacle.id == a).unwrap();
        let apart = who.at(window.1).unwrap().pose.position
            - scene.ego.track.at(window.1).unwrap().pose.position;
        apart.norm()
    };
    let told = one(format!("Obstacle {a} is at a distance of {centre:.2} m"));
    assert_eq!(
        (told.judgement, told.basis),
        (Judgement::Right, ClaimBasis::Centres)
    );
    // The opposite side is wrong, a sign that is written counts.
    let side = if now.gap_long > 0.0 {
        "behind"
    } else {
        "in front of"
    };
    assert_eq!(
        one(format!("Obstacle {a} is {side} the ego.")).judgement,
        Judgement::Wrong
    );
    let turned = one(format!(
        "Obstacle {a}: longitudinal gap {:+.2} m",
        -now.gap_long
    ));
    assert_eq!(turned.judgement, Judgement::Wrong, "{turned:?}");
    let touch = one(format!("Obstacle {a} collides at step {}", window.1));
    assert_eq!(
        (touch.judgement, touch.is.as_str()),
        (Judgement::Wrong, "no contact at any step")
    );
    let step = window.1;
    assert_eq!(
        touch.line(),
        format!("{a}: claimed contact, actual no contact at any step (step {step})")
    );
}

#[test]
fn a_value_of_an_earlier_step_is_neither_right_nor_wrong() {
    let scene = scene();
    let (a, b, window) = cast(&scene);
    let moved = |id| {
        (relation(&scene, id, window.0).gap_long - relation(&scene, id, window.1).gap_long).abs()
    };
    let who = if moved(a) > moved(b) { a } else { b };
    assert!(moved(who) > 0.5, "{}", moved(who));
    let text = format!(
        "Obstacle {who}: longitudinal gap {:.2} m",
        relation(&scene, who, window.0).gap_long
    );
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some(window));
    let all = checked(&text, &subject);
    assert!(matches!(all[0].judgement, Judgement::Unknown(_)), "{all:?}");
    let unknown = Subject::new(&scene, TimeOrigin::Recording, None);
    assert!(matches!(
        checked(&text, &unknown)[0].judgement,
        Judgement::Unknown(_)
    ));
}

#[test]
fn what_the_built_in_judge_says_is_right() {
    let mut all = 0;
    for entry in bundled() {
        let scenario = entry.read().unwrap();
        let Some(ego) = entry.recorded_ego(&scenario).unwrap() else {
            continue;
        };
        let scene = Scene::new(scenario, ego);
        let window = Window::ending_at(&scene, scene.last_step(), 10);
        for task in nearmiss_scene::verdict::Task::VERDICTS {
            let said = nearmiss_scene::judge::judge(&scene, task, &window);
            let subject = Subject::new(
                &scene,
                TimeOrigin::Recording,
                Some((window.first(), window.last())),
            );
            for text in [&said.reasoning, &said.verdict.justification] {
                for checked in checked(text, &subject) {
                    all += 1;
                    assert_ne!(
                        checked.judgement,
                        Judgement::Wrong,
                        "{}: {}\n{text}",
                        entry.name,
                        checked.line()
                    );
                }
            }
        }
    }
    assert!(all > 10, "{all}");
}

#[test]
fn foreign_text_does_no_harm() {
    let scene = scene();
    let (a, ..) = cast(&scene);
    let subject = Subject::new(&scene, TimeOrigin::Recording, None);
    for text in [
        "",
        "|",
        "||\n||",
        "| ü |\n|-|\n| 301 |",
        "İobstacle 301 ẞ -−– 3 m",
        "{{{}}}",
        "**",
        "#",
        "9".repeat(400).as_str(),
    ] {
        let long = format!("{text} obstacle {a} {text} distance 3.5 m {text}");
        for claim in find(&long, &subject) {
            assert!(long.get(claim.span.clone()).is_some(), "{long}: {claim:?}");
        }
    }
}

#[test]
fn the_plainest_sentences() {
    let (a, b) = ids();
    for (text, claims) in [
        (
            format!("The gap to obstacle {a} is 4.17 m."),
            vec![format!("{a} distance: 4.17 m")],
        ),
        (
            format!("- At step 54 the distance to obstacle {a} is 4.17 m and it is closing."),
            vec![
                format!("{a} distance: 4.17 m @54"),
                format!("{a} motion: closing @54"),
            ],
        ),
        (
            format!("The TTC of obstacle {a} is 0.43 s."),
            vec![format!("{a} TTC: 0.43 s")],
        ),
        (
            format!("Obstacle {a} is 1.27 m in front of the ego."),
            vec![
                format!("{a} distance: 1.27 m"),
                format!("{a} direction: in front of the ego"),
            ],
        ),
        (
            format!(
                "The ego follows obstacle {a}. The gap to obstacle {a} is 3 m, and the TTC of obstacle {a} is 2.5 s."
            ),
            vec![
                format!("{a} direction: follows"),
                format!("{a} distance: 3 m"),
                format!("{a} TTC: 2.5 s"),
            ],
        ),
        (
            format!("The gap between obstacle {a} and obstacle {b} is 3 m."),
            vec![],
        ),
    ] {
        assert_eq!(brief(&text), claims, "{text}");
    }
}

#[test]
fn a_mention_inside_a_sentence_does_not_change_the_subject() {
    let (a, b) = ids();
    let text = format!(
        "**Obstacle {a} Analysis:**\n\n\
         - **Position and Motion:**\n\
         \x20 - Recent Position: Rear-right of the ego with longitudinal distance of -12.11 m and lateral distance of -0.53 m.\n\
         \x20 - Relative Velocity: Longitudinal: 2.23 m/s toward ego, Lateral: 0.63 m/s toward ego.\n\
         - **Risk:**\n\
         \x20 - **Longitudinal:** The distance is large (-12.11 m), a lower risk compared to Obstacle {b}. It is 9 m.\n\
         \x20 - **TTC:** Longitudinal: |12.11 m| / 2.23 m/s = ~5.43 seconds\n\n\
         **Obstacle {b} Analysis:**\n- Longitudinal distance: 4.5 m"
    );
    let all = brief(&text);
    for claim in [
        format!("{a} gap longitudinal: -12.11 m"),
        format!("{a} gap lateral: -0.53 m"),
        format!("{a} relative velocity longitudinal: 2.23 m/s"),
        format!("{a} relative velocity lateral: 0.63 m/s"),
        format!("{a} TTC longitudinal: 5.43 seconds"),
    ] {
        assert!(all.contains(&claim), "{claim}: {all:#?}");
    }
    let of_b: Vec<_> = all
        .iter()
        .filter(|c| c.starts_with(&b.to_string()))
        .collect();
    assert_eq!(of_b, [&format!("{b} gap longitudinal: 4.5 m")]);
}

#[test]
fn after_an_aside_the_heading_counts_and_where_two_are_meant_nobody() {
    let (a, b) = ids();
    let text = format!(
        "### Obstacle {a}\n- Obstacle {b} is closer.\n- Lateral distance: 3.25 m\n\
         - It cuts in front of the path of obstacle {b}:\n  - Lateral distance: 7 m\n"
    );
    assert_eq!(brief(&text), [format!("{a} gap lateral: 3.25 m"),]);
    let text = format!(
        "Obstacle {a} is near. Although it closes in (longitudinal gap 5.5 m), the risk is lower than that of obstacle \
         {b}. The lateral gap is 2 m.\n\nFor obstacle {b} the longitudinal gap is 8.25 m."
    );
    assert_eq!(
        brief(&text),
        [
            format!("{a} motion: closes in"),
            format!("{a} gap longitudinal: 5.5 m"),
            format!("{a} gap lateral: 2 m"),
            format!("{b} gap longitudinal: 8.25 m"),
        ]
    );
}

#[test]
fn what_may_mean_something_else_cannot_be_told() {
    let scene = scene();
    let (a, b, window) = cast(&scene);
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some(window));
    let (mine, other) = (relation(&scene, a, window.1), relation(&scene, b, window.1));
    assert!((mine.gap_long - other.gap_long).abs() > 1.0);
    let judged = |text: String| checked(&text, &subject).remove(0).judgement;
    let heading = format!(
        "### Obstacle {a}\n- Longitudinal gap: {:.2} m",
        other.gap_long
    );
    assert_eq!(
        judged(heading),
        Judgement::Unknown("true for another obstacle")
    );
    let named = format!("Obstacle {a}: longitudinal gap {:.2} m", other.gap_long);
    assert_eq!(judged(named), Judgement::Wrong, "it says whom it is about");
}

/// The steps of the claims in a text about window steps up to `now`, with times relative to it or to the recording.
fn steps(text: &str, times: TimeOrigin, window: (i64, i64)) -> Vec<Option<i64>> {
    let scene = scene();
    let subject = Subject::new(&scene, times, Some(window));
    let claims = find(text, &subject);
    claims.into_iter().map(|claim| claim.step).collect()
}

#[test]
fn times_count_back_from_the_end_of_the_window() {
    let scene = scene();
    let (a, _, (_, end)) = cast(&scene);
    let last = end - 20;
    let window = (last - 9, last);
    let of = |text: String| steps(&text, TimeOrigin::WindowEnd, window);
    for (when, step) in [
        ("At t = -0.50 s", last - 5),
        ("At t = 0.00 s", last),
        ("At -0.3 s", last - 3),
        ("0.5 s ago", last - 5),
        ("0.2 s before the end", last - 2),
    ] {
        let text = format!("{when}, obstacle {a} is at a distance of 7.00 m.");
        assert_eq!(of(text), [Some(step)], "{when}");
    }
    let now = format!("Obstacle {a} is now at a distance of 7.00 m.");
    assert_eq!(of(now), [Some(last)]);
    let heading = format!("### t = -0.90 s\n\nObstacle {a} is at a distance of 7.00 m.");
    assert_eq!(of(heading), [Some(last - 9)]);
    // No time of the recording, and none after the window.
    let later = format!("At t = 0.50 s, obstacle {a} is at a distance of 7.00 m.");
    assert_eq!(of(later), []);
    // A step of the reasoning is no time.
    let reasoning = format!("### Step 1: distances\n\nObstacle {a} is at a distance of 7.00 m.");
    assert_eq!(of(reasoning), [None]);
    let contact = format!("Obstacle {a} collides with the ego at t = -0.10 s.");
    // That it happened, and when.
    assert_eq!(of(contact), [Some(last - 1); 2]);
}

#[test]
fn answers_to_descriptions_with_absolute_times_are_read_as_before() {
    let scene = scene();
    let (a, _, window) = cast(&scene);
    let of = |text: String| steps(&text, TimeOrigin::Recording, window);
    let text = format!("At t = 0.50 s, obstacle {a} is at a distance of 7.00 m.");
    assert_eq!(of(text), [Some(5)]);
    let text = format!("Obstacle {a} is now at a distance of 7.00 m.");
    assert_eq!(of(text), [None]);
}

#[test]
fn the_messages_tell_what_times_count_from() {
    let scene = scene();
    let window = Window::ending_at(&scene, 20, 5);
    let told = |frame| {
        let options = nearmiss_scene::description::Options {
            obstacle: scene.participants().next().map(|p| p.obstacle.id),
            ..Default::default()
        };
        let text = nearmiss_scene::description::describe(&scene, frame, &window, &options);
        TimeOrigin::from_messages(
            &serde_json::json!([{ "content": text.unwrap().text }]).to_string(),
        )
    };
    use nearmiss_scene::description::Frame;
    for frame in [Frame::Ego, Frame::Metrics, Frame::Cartesian] {
        assert_eq!(told(frame), TimeOrigin::WindowEnd);
    }
    assert_eq!(told(Frame::Trajectory), TimeOrigin::Recording);
    let old = r#"[{"content": "Step 36, t = 3.60 s:"}]"#;
    assert_eq!(TimeOrigin::from_messages(old), TimeOrigin::Recording);
}

#[test]
fn sentences_with_a_quantity_that_were_not_understood_are_found() {
    let scene = scene();
    let (id, ..) = cast(&scene);
    let subject = Subject::new(&scene, TimeOrigin::Recording, None);
    let text = format!(
        "Car {id} is at a distance of 3.00 m. Car {id} wobbles by 7.77 m sideways, oddly.\n\
         It has a risk score of 2. Nothing of {id} here. Car {id} brakes from step 5 (0.5 s) on. The ego drives 10 m/s.\n\
         ```json\n{{\"id\": {id}, \"reason\": \"{id} is 5 m off\"}}\n```\n"
    );
    let unread = not_understood(&text, &subject);
    let words: Vec<&str> = unread.iter().map(|at| text[at.clone()].trim()).collect();
    assert_eq!(
        words,
        [format!("Car {id} wobbles by 7.77 m sideways, oddly.")]
    );
}

#[test]
fn the_fence_around_all_of_an_answer_is_not_shown() {
    for (answer, shown) in [
        ("```markdown\n# Why\n\nso\n```\n", "# Why\n\nso\n"),
        ("\n```json\n{\"a\": 1}\n```", "{\"a\": 1}\n"),
        ("```json {\"a\": 1}```", "{\"a\": 1}"),
        ("```\n{\n}```\n", "{\n}"),
        ("```md\nas\n```json\n{}\n```\n```", "as\n```json\n{}\n```\n"),
        // What arrives.
        ("```", ""),
        ("```markdown\n# W", "# W"),
        // A part of the answer, and code, keep theirs.
        ("why\n```json\n{}\n```", "why\n```json\n{}\n```"),
        ("```json\n{}\n```\nso", "```json\n{}\n```\nso"),
        ("```python\nx\n```", "```python\nx\n```"),
        ("`a` is so", "`a` is so"),
    ] {
        assert_eq!(shown_text("", answer, false), shown, "{answer}");
        assert_eq!(shown_text("", answer, true), answer, "as sent");
    }
    let reasoned = "```json\n{\"justification\": \"so\", \"collision\": true}\n```";
    let shown = shown_text("", reasoned, false);
    assert_eq!(shown.trim(), "so\n\n{\"collision\": true}");
}

#[test]
fn the_built_in_judge_is_understood() {
    for entry in bundled() {
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        let scene = Scene::new(scenario, ego);
        let text = nearmiss_scene::judge::judge_collision(&scene, Thresholds::shipped()).reasoning;
        let subject = Subject::new(&scene, TimeOrigin::Recording, None);
        let unread = not_understood(&text, &subject);
        let words: Vec<&str> = unread.iter().map(|at| &text[at.clone()]).collect();
        // When it was, between the steps, is no claim about a step.
        let words: Vec<&str> = { words.into_iter() }
            .filter(|words| !words.starts_with("First touch"))
            .collect();
        assert!(words.is_empty(), "{}: {words:?}", entry.name);
    }
}
