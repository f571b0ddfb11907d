//! Filter, order and grouping of the list as one view.

use super::{Grouping, List, Order};
use nearmiss_settings::SavedView;

impl List {
    /// The list as it is.
    #[must_use]
    pub fn view(&self) -> SavedView {
        SavedView::new(
            &self.filter,
            self.order.id(),
            self.turned,
            self.grouping.name(),
        )
    }

    /// Shows a view; gives what of it is not known here and was left out.
    pub fn show_view(&mut self, view: &SavedView) -> Vec<String> {
        let mut unknown = Vec::new();
        let order = Order::parse(&view.sort);
        if order.is_none() && !view.sort.is_empty() {
            unknown.push(format!("the order `{}`", view.sort));
        }
        let grouping = Grouping::parse(&view.group);
        if grouping.is_none() && !view.group.is_empty() {
            unknown.push(format!("the grouping `{}`", view.group));
        }
        self.turned = view.reversed && order.is_some();
        self.filtering = None;
        self.set_order(order.unwrap_or_default());
        self.group_by(grouping.unwrap_or_default());
        self.set_filter(view.filter.clone());
        unknown
    }
}
