//! Renders a template with sample values, so that its errors show before a model is asked.

use std::sync::Arc;

use super::question::{AttackTerms, Case, CaseError, prepare};
use super::settings::Settings;
use nearmiss_ask::prompts::{Library, RenderError, Techniques};
use nearmiss_base::system::unknown;
use nearmiss_formats::bundled;
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;

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
