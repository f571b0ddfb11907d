//! An experiment: what its file asks, what that costs, how far it is; asking it, after a yes.

mod draw;

use ratatui::Frame;
use ratatui::layout::Rect;

use super::{Screen, Step};
use crate::action::{Action, Scope};
use crate::keymap::{Code, Key};
use crate::message::Effect;
use crate::model::Model;
use crate::widgets::hints::{self, Hint, fixed};

/// The screen; what it shows is kept in the model, so that it is there when it is opened again.
#[derive(Debug, Default)]
pub struct ExperimentScreen {
    scroll: usize,
}

impl Screen for ExperimentScreen {
    fn scope(&self) -> Scope {
        Scope::Experiment
    }

    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        if !model.experiment.confirming {
            return None;
        }
        match key.code {
            Code::Char('y') | Code::Enter => Some(Step::Perform(Action::Accept)),
            Code::Char('n') => Some(self.on_action(model, Action::Cancel)),
            _ => None,
        }
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        let view = &mut model.experiment;
        match action {
            // Nothing else happens until that is answered.
            _ if view.confirming => {
                view.confirming = !matches!(action, Action::Cancel | Action::Quit);
                Step::stay()
            }
            Action::Cancel => {
                // What is being read is of no use now; what is asked goes on.
                let reading = view.working.take().and(view.job.take());
                Step::Close(reading.map(Effect::Cancel).into_iter().collect())
            }
            Action::ExperimentText => {
                view.shows_text = !view.shows_text;
                self.scroll = 0;
                Step::stay()
            }
            _ => Step::Ignored,
        }
    }

    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn moves(&self, model: &Model) -> bool {
        model.experiment.asking.is_some()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        draw::draw(frame, screen, model, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let view = &model.experiment;
        if view.confirming {
            return fixed(&[
                ("y", "ask"),
                ("Enter", "ask"),
                ("n", "cancel"),
                ("Esc", "cancel"),
            ]);
        }
        let mut idle = Vec::new();
        if view.asking.is_none() {
            idle.push(Action::StopExperiment);
        } else {
            idle.extend([Action::RunExperiment, Action::EditExperiment]);
        }
        if !view
            .outline
            .as_ref()
            .is_some_and(|outline| outline.is_split)
        {
            idle.push(Action::ExperimentPart);
        }
        hints::own_but(model, Scope::Experiment, &idle)
    }
}
