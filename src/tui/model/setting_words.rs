//! The present state of settings that a key switches, for menus.

use super::Model;
use crate::action::Action;

impl Model {
    /// The present state of what an action switches, in a word; `None` for actions that switch nothing.
    #[must_use]
    pub fn state_of(&self, action: Action) -> Option<&str> {
        let is = |on: bool| Some(if on { "on" } else { "off" });
        let techniques = self.decided().techniques;
        match action {
            Action::ToggleTask => Some(self.task.name()),
            Action::ToggleFrame => Some(self.frame.name()),
            Action::ToggleCp => is(techniques.cp),
            Action::ToggleCot => is(techniques.cot),
            Action::ToggleIcl => is(techniques.icl),
            Action::ToggleTools => is(self.tools),
            Action::PromptView => Some(self.prompt.view.name()),
            Action::Follow => is(self.camera.follow),
            Action::EgoUp => is(self.camera.ego_up),
            Action::Mouse => is(self.mouse),
            Action::GroupScenarios => Some(self.list.grouping.name()),
            Action::NextForecast => Some(self.driver.forecast.name()),
            Action::NextPlanner => Some(self.driver.planner_name()),
            Action::PlotMeasure => Some(self.plot.measure.id),
            Action::PickTheme => Some(&self.look.chosen),
            _ => None,
        }
    }
}
