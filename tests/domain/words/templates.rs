//! Every shipped template, filled with every combination of techniques, and its examples.

use nearmiss::description::{Form, Frame, Options, describe};
use nearmiss::evaluation::dry_render;
use nearmiss::prompts::{Library, Pack, Prompt, answer_form, answer_keys, render};
use nearmiss::scenario::Window;
use nearmiss::verdict::{self, ParsedAnswer, Task};
use serde_json::{Value, json};

use crate::words::scene;

fn schema(task: &str) -> Value {
    verdict::schema(Task::parse(task).unwrap())
}

/// A shipped template, filled for a bundled scenario.
pub fn filled(file: &str, bits: u8, form: Form) -> Prompt {
    with_contact(file, bits, form, false)
}

/// The same, with contact said or not.
pub fn with_contact(file: &str, bits: u8, form: Form, contact: bool) -> Prompt {
    let library = Library::load(None);
    let (template, _) = library.file(file).unwrap();
    let front = &template.front;
    let scene = scene("ZAM_RedLight-1_1_T-1");
    let obstacle = scene.participants().next().map(|p| p.obstacle.id);
    let options = Options {
        form,
        contact,
        obstacle,
        ..Options::default()
    };
    let frame = Frame::parse(&front.frame).unwrap();
    let window = Window::ending_at(&scene, 50, 3);
    let described = describe(&scene, frame, &window, &options).unwrap();
    let schema = schema(&front.task);
    let levels: Value = nearmiss::metrics::RISK_LEVELS
        .levels
        .iter()
        .map(|level| json!(level))
        .collect();
    let attacker = json!({
        "kind": "car", "style": "human", "acceleration": 3.5, "switch_speed": 7.319, "power": 55.551,
        "braking": 7.59, "lateral": 4.0, "friction": 7.59, "jerk": 12.65, "speed": 50.8, "radius": 5.9,
        "curvature": 0.169, "steering": 0.412, "steering_rate": 0.4, "wheelbase": 2.578, "rear_to_centre": 1.4,
        "on_road": true, "least_distance": 0.1, "least_speed": 0.1,
    });
    let values = json!({
        "task": front.task, "frame": front.frame,
        "cp": bits & 1 != 0, "cot": bits & 2 != 0, "icl": bits & 4 != 0,
        "description": described.text, "form": form.name(), "contact": contact, "axes": "heading", "road": false, "measures": [], "horizon": 2.0, "dt": 0.1, "spacing": 0.1, "radius": 30.0, "reach": 2.0, "give": 2.0, "far": 20.0,
        "ego": 1, "obstacle": obstacle, "scenario": "s",
        "window": {"first": 48, "last": 50, "steps": 3, "described": 3, "seconds": 0.3, "from": 4.8, "until": 5.0},
        "risk_levels": levels,
        "thresholds": [{"measure": "ttc", "name": "time to collision", "value": 1.5, "unit": "s",
            "level": "critical", "source": "a standard"}],
        "critical": [{"name": "time to collision", "from": false, "value": 1.5, "unit": "s",
            "level": "critical", "source": "a standard"}],
        "attacker": attacker,
        "reaction": 0.5,
        "limits": {"acceleration": 3.5, "deceleration": 8.0, "lateral": 8.0, "curvature": 0.2},
        "answer_form": answer_form(&schema), "answer_keys": answer_keys(&schema),
        "answer_schema": schema.to_string(),
    });
    render(file, &template.source, library.fragments(), values).unwrap()
}

fn files() -> Vec<String> {
    of_pack(Pack::Standard)
}

/// The shipped templates of a pack.
pub fn of_pack(pack: Pack) -> Vec<String> {
    let library = Library::load(None);
    let templates = library
        .templates()
        .filter(|(_, template, _)| template.front.pack == pack);
    templates.map(|t| t.0.to_string()).collect()
}

#[test]
fn the_tasks_have_the_frames_they_need() {
    let library = Library::load(None);
    for (task, frames) in [
        ("collision", &["ego", "cartesian", "metrics"][..]),
        ("safety", &["ego", "cartesian", "metrics"]),
        ("recording", &["ego", "metrics"]),
        ("attacker", &["metrics", "ego"]),
        ("trajectory", &["trajectory"]),
    ] {
        for frame in frames {
            assert!(library.find(task, frame).is_some(), "{task} {frame}");
        }
    }
}

#[test]
fn every_template_is_filled_with_every_combination() {
    for file in files() {
        let mut texts = Vec::new();
        for bits in 0..8 {
            for form in Form::ALL {
                let Prompt { system, user } = filled(&file, bits, form);
                let text = format!("{system}\n{user}");
                assert!(
                    !text.contains("{{") && !text.contains("{%"),
                    "{file} {bits}"
                );
                assert!(!text.contains("\n\n\n"), "{file} {bits}: a hole in\n{text}");
                assert_eq!(text.contains("## Example"), bits & 4 != 0, "{file}");
                assert_eq!(text.contains("Work step by step"), bits & 2 != 0, "{file}");
                // What is the same for every scene comes first, the scene last.
                assert!(system.contains("## Answer") && !user.contains("## Answer"));
                assert!(user.trim_end().lines().count() > 4, "{file}");
                texts.push(text);
            }
        }
        texts.sort();
        texts.dedup();
        // The words with a picture alone have one form.
        let texts_wanted = if file.ends_with("-picture.md") { 8 } else { 16 };
        assert_eq!(
            texts.len(),
            texts_wanted,
            "{file}: every choice has its text"
        );
    }
}

#[test]
fn a_trial_fills_what_the_program_can_ask() {
    let library = Library::load(None);
    let mut tried = 0;
    for (file, template, _) in library.templates() {
        dry_render(&library, file).unwrap();
        tried += usize::from(Task::parse(&template.front.task).is_some());
    }
    assert_eq!(tried, 18);
}

#[test]
fn the_prompt_states_every_key_of_the_schema() {
    for file in files() {
        let library = Library::load(None);
        let task = library.file(&file).unwrap().0.front.task.clone();
        let system = filled(&file, 0, Form::Prose).system;
        let properties = schema(&task)["properties"].as_object().unwrap().clone();
        for key in properties.keys() {
            assert!(system.contains(&format!("\"{key}\": ")), "{file}: {key}");
        }
    }
}

/// The JSON of the examples.
fn examples(system: &str) -> Vec<&str> {
    let lines = system.lines();
    lines
        .filter(|line| line.starts_with("{\"justification\": "))
        .collect()
}

#[test]
fn examples_answer_as_the_schema_asks_and_are_balanced() {
    for file in files() {
        let library = Library::load(None);
        let task = library.file(&file).unwrap().0.front.task.clone();
        let system = filled(&file, 4, Form::Prose).system;
        let answers = examples(&system);
        assert!(!answers.is_empty(), "{file}");
        for answer in &answers {
            let value: Value = serde_json::from_str(answer).unwrap();
            let keys: Vec<&String> = value.as_object().unwrap().keys().collect();
            let schema = schema(&task);
            let asked: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
            assert_eq!(keys, asked, "{file}: the order of the schema");
        }
        let task = Task::parse(&task).unwrap();
        let read = |answer: &&str| verdict::read(task, answer).unwrap();
        let readings: Vec<_> = answers.iter().map(read).collect();
        for reading in &readings {
            assert_eq!(
                reading.how,
                verdict::ParseQuality::Strict,
                "{file}: {reading:?}"
            );
        }
        let yes = readings.iter().filter(|reading| match &reading.said {
            ParsedAnswer::Verdict(verdict) => verdict.dangerous,
            ParsedAnswer::Attacker(choice) => choice.attacker.is_some(),
            ParsedAnswer::Trajectory(_) => true,
        });
        let expected = match task {
            Task::Collision | Task::Safety | Task::Recording => (1, 3),
            Task::Attacker => (2, 3),
            Task::Trajectory => (1, 1),
        };
        assert_eq!((yes.count(), readings.len()), expected, "{file}");
    }
}

#[test]
fn knowledge_comes_from_the_tables() {
    for file in files() {
        let text = filled(&file, 1, Form::Prose).system;
        for level in &nearmiss::metrics::RISK_LEVELS.levels {
            if let Some(distance) = level.distance {
                let told = format!("| {distance} m |")
                    .replace("| 0 m", "| 0.0 m")
                    .replace("| 1 m", "| 1.0 m")
                    .replace("| 3 m", "| 3.0 m")
                    .replace("| 5 m", "| 5.0 m");
                assert!(text.contains(&told), "{file}: {told}");
            }
        }
        let metrics = text.contains("time to collision up to 1.5 s: critical (a standard)");
        assert_eq!(metrics, file.ends_with("-metrics.md"), "{file}");
    }
}
