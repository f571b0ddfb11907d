//! Two versions of a prompt over many scenarios as one table: what changed, for better or worse, and what it costs.

mod choice;
mod draw;

use ratatui::Frame;
use ratatui::layout::Rect;

use super::{Screen, Step};
use crate::action::{Action, Scope};
use crate::message::{Effect, Mouse};
use crate::model::Model;
use crate::widgets::hints::{self, Hint};

/// The screen; what it shows is kept in the model, so that it is there when it is opened again.
#[derive(Debug)]
pub struct VersionsScreen;

impl Screen for VersionsScreen {
    fn scope(&self) -> Scope {
        Scope::Versions
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        use Action::*;
        match action {
            Cancel if model.versions.choosing.take().is_some() => {}
            Cancel | CompareVersions => {
                let job = model.versions.job.take();
                return Step::Close(job.map(Effect::Cancel).into_iter().collect());
            }
            Up | Down | PageUp | PageDown | Top | Bottom => moved(model, action),
            OpenVersions if model.versions.choosing.is_some() => return choice::chosen(model),
            FirstVersion => choice::open(model, 0),
            SecondVersion => choice::open(model, 1),
            SwapVersions => {
                if let Some(sides) = &mut model.versions.sides {
                    sides.swap(0, 1);
                    return Step::Perform(ChangeVersion);
                }
            }
            NextChange => {
                if !model.versions.next_change() {
                    let key = model.look.key(AskVersions);
                    model.say(match model.versions.compares() {
                        true => "no answer changed".to_string(),
                        false => format!("nothing is compared yet: {key} asks for what is missing"),
                    });
                }
            }
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn on_mouse(&mut self, model: &mut Model, mouse: Mouse) -> Step {
        match mouse {
            Mouse::WheelUp(_) => moved(model, Action::Up),
            Mouse::WheelDown(_) => moved(model, Action::Down),
            Mouse::Press(_) | Mouse::Drag(_) | Mouse::Release(_) => {}
        }
        Step::stay()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        draw::draw(frame, screen, model);
        if let Some((side, selected)) = model.versions.choosing {
            choice::draw(frame, screen, model, (side, selected));
        }
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        if model.versions.choosing.is_some() {
            return hints::fixed(&[("↑↓", "select"), ("Enter", "choose"), ("Esc", "back")]);
        }
        hints::own(model, Scope::Versions)
    }
}

fn moved(model: &mut Model, action: Action) {
    let page = model.versions.rows.get().saturating_sub(1).max(1);
    let lines = action.lines(isize::try_from(page).unwrap_or(1));
    let versions = model.prompt_versions().len();
    model.versions.move_by(lines, versions);
}
