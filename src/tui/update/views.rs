//! Saved views of the list: opens their screen and shows a chosen one.

use super::super::message::Effect;
use super::super::model::Model;
use super::super::screens::saved_views::SavedViewsScreen;
use super::super::tasks::scenarios::ranking;
use super::open_current;
use crate::screens::saved_views::ListViews;

/// Shows the view that was chosen, else opens the list of them.
pub fn perform(model: &mut Model) -> Vec<Effect> {
    let Some(name) = model.list.chosen_view.take() else {
        model.screens.open(SavedViewsScreen::default());
        return vec![ListViews::Read.into()];
    };
    let Some(view) = model.list.views.get(&name).cloned() else {
        model.say(format!("view `{name}` no longer exists"));
        return Vec::new();
    };
    let unknown = model.list.show_view(&view);
    match unknown.as_slice() {
        [] => model.say(format!("view `{name}`")),
        unknown => model.complain(format!(
            "view `{name}` uses {}, unknown to this version of nearmiss; the rest is shown",
            unknown.join(" and ")
        )),
    }
    let mut effects: Vec<Effect> = ranking(model).into_iter().collect();
    effects.extend(open_current(model));
    effects
}
