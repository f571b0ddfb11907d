//! Validates the user's templates by rendering them with sample values: those that fail are not used.

use std::sync::Arc;

use nearmiss_ask::prompts::{Library, RenderError, Techniques};
use nearmiss_base::system::unknown;
use nearmiss_formats::bundled;
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;

use super::question::{AttackTerms, Case, CaseError, prepare};
use super::settings::Settings;

/// The library without the user's files that no prompt can be made of: each is tried on a bundled scenario, and where
/// that fails the shipped one is in its place, with a problem that names file, line and mistake.
#[must_use]
pub fn validate(mut library: Library) -> Library {
    let files: Vec<String> = library.templates().map(|t| t.0.to_string()).collect();
    for file in files {
        // A fragment may be at fault, then another, then the template itself.
        while let Some((culprit, message)) = at_fault(&library, &file) {
            if !library.set_aside(&culprit, message) {
                break;
            }
        }
    }
    library
}

/// Which file of the user spoils a template, and how; `None` if it can be filled or none of it is the user's.
fn at_fault(library: &Library, file: &str) -> Option<(String, String)> {
    let users = library.users_in(file);
    let first = users.first()?;
    let error = dry_render(library, file).err()?;
    let culprit = users.iter().find(|one| **one == error.file);
    let Some(line) = error.line.filter(|_| culprit.is_some()) else {
        let message = match culprit {
            Some(_) => error.message,
            None => error.to_string(),
        };
        return Some((culprit.unwrap_or(first).clone(), message));
    };
    let culprit = culprit.unwrap_or(first);
    let text = library.source(culprit).map_or("", |(text, _)| text);
    let written = text.lines().nth(line - 1).unwrap_or_default().trim();
    let message = format!("line {line}: {}, in `{written}`", error.message);
    Some((culprit.clone(), message))
}

/// Renders the template in a file for a bundled scenario, with every combination of techniques and contact.
///
/// # Errors
/// The template names an unknown task or frame, or cannot be rendered: with file and line, where they are known.
pub fn dry_render(library: &Library, file: &str) -> Result<(), RenderError> {
    let wrong = |message: String| RenderError {
        file: file.to_string(),
        line: None,
        message,
    };
    let Some((template, _)) = library.file(file) else {
        return Err(wrong("template not found".into()));
    };
    let front = &template.front;
    let Some(task) = Task::parse(&front.task) else {
        let known = Task::ALL.map(Task::name);
        return Err(wrong(unknown("task", &front.task, known)));
    };
    let Some(frame) = Frame::parse(&front.frame) else {
        let known = Frame::ALL.map(Frame::name);
        return Err(wrong(unknown("frame", &front.frame, known)));
    };
    let Some(scene) = scene() else {
        return Err(wrong(
            "no bundled scenario can be opened for a trial".into(),
        ));
    };
    let obstacle = scene.participants().next().map(|p| p.obstacle.id);
    for bits in 0..16_u8 {
        let settings = Settings {
            techniques: Some(Techniques {
                cp: bits & 1 != 0,
                cot: bits & 2 != 0,
                icl: bits & 4 != 0,
            }),
            contact: Some(bits & 8 != 0),
            obstacle: obstacle.filter(|_| frame.is_of_one_obstacle()),
            ..Settings::default()
        };
        let decided = settings.with(&front.defaults);
        let case = Case {
            name: scene.scenario.header.benchmark_id.clone(),
            scene: scene.clone(),
            task,
            frame,
            techniques: decided.techniques,
            window: Window::ending_at(&scene, i64::MAX, decided.history),
            options: decided.options,
            thresholds: Arc::new(Thresholds::shipped().clone()),
            horizon: Case::HORIZON,
            attack: AttackTerms::default(),
        };
        let draft = Some((file, template.source.as_str()));
        prepare(case, library, draft).map_err(|error| match error {
            CaseError::Render(error) => error,
            other => wrong(other.to_string()),
        })?;
    }
    Ok(())
}

fn scene() -> Option<Arc<Scene>> {
    bundled().iter().find_map(|entry| {
        let scenario = entry.read().ok()?;
        let ego = entry.recorded_ego(&scenario).ok()??;
        Some(Arc::new(Scene::new(scenario, ego)))
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_ask::prompts::{Fallback, Origin};

    #[test]
    fn what_cannot_be_filled_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: String| {
            std::fs::write(folder.path().join(name), text).unwrap();
        };
        let shipped = |name: &str| Library::shipped(name).unwrap().to_string();
        let ego = shipped("collision-ego.md");
        write(
            "collision-ego.md",
            ego.replace("{{ description }}", "{{ nonsense }}"),
        );
        write("mine.md", ego.replace("collision-ego", "mine"));
        let unknown = "[defaults]\nmeasures = [\"ttc\", \"darc\"]\n+++\n{% block";
        let metrics = shipped("collision-metrics.md");
        write("measured.md", metrics.replacen("+++\n{% block", unknown, 1));
        write("_critical.md", "{{ no_such_value }}\n".into());
        let library = validate(Library::load(Some(folder.path())));
        let (_, origin) = library.file("collision-ego.md").unwrap();
        assert_eq!(*origin, Origin::Shipped);
        assert!(library.is_users("mine.md") && !library.is_users("_critical.md"));
        let said: Vec<String> = library.problems.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), 3, "{said:?}");
        let line = 1 + ego.lines().position(|l| l == "{{ description }}").unwrap();
        let of = |name: &str| said.iter().find(|s| s.contains(name)).unwrap();
        let told = of("collision-ego.md");
        assert!(told.contains(&format!("line {line}: ")), "{told}");
        assert!(told.contains("`{{ nonsense }}`"), "{told}");
        assert!(of("_critical.md").contains("line 1: "), "{said:?}");
        let told = of("measured.md");
        assert!(
            told.contains("line 9: unknown measure `darc`; did you mean `drac`"),
            "{told}"
        );
        for problem in &library.problems {
            let own = problem.path.ends_with("measured.md");
            let instead = if own {
                Fallback::Usual
            } else {
                Fallback::Shipped
            };
            assert_eq!(problem.instead, instead);
        }
    }
}
