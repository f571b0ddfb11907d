//! The list of scenarios: filtered while typing, sorted and grouped, with the facts loaded so far.
//!
//! Arriving rows are only recorded; [`List::settle`] reorders them at most once a frame.

pub mod order;

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use nearmiss_formats::{Entry, PassedOver, SearchResults};
use nearmiss_scene::metrics::Measure;
use nearmiss_settings::{SavedView, SavedViews, Tags};
use nearmiss_workflow::{Agreement, Filterable};
use strum::{IntoStaticStr, VariantArray};
use unicode_width::UnicodeWidthStr;

use crate::loaded::{Facts, Ranked, StandInEgo};
use crate::model::Place;

pub use nearmiss_workflow::{Filter, HEADLINE, Matching, TERMS, WordMatch, nearest};
pub use order::{ListIndex, Order, Row};

/// The scenarios.
#[derive(Debug, Default)]
pub struct List {
    /// All of them, in the order in which they came; a place here never changes.
    pub rows: Vec<Row>,
    /// Whether the search for them has ended.
    pub found: bool,
    /// Skipped files that looked like scenarios, and folders that could not be searched.
    pub passed_over: Vec<PassedOver>,
    /// Places of those that the filter lets through, in their order.
    pub visible: Vec<usize>,
    /// The displayed lines.
    pub lines: Vec<Line>,
    /// The groups that are shown.
    pub groups: Vec<Group>,
    /// The selected line.
    pub selected: usize,
    /// The filter as it is typed.
    pub filter: String,
    /// The filter that Esc removed last.
    pub dropped: Option<String>,
    /// How the words of the filter matched.
    pub matched: WordMatch,
    /// The filter as it was read.
    pub read: Filter,
    /// The opened one, as a place in `rows`.
    pub opened: Option<usize>,
    /// The filter is being typed, and what to go back to.
    pub filtering: Option<Filtering>,
    /// By what it is sorted.
    pub order: Order,
    /// Whether the order is turned around.
    pub turned: bool,
    /// An order was chosen and nothing done since: its first scenario is opened as soon as it is known.
    pub leads: bool,
    /// By what it is grouped.
    pub grouping: Grouping,
    /// The user's own tags.
    pub tags: Tags,
    /// Saved views of it.
    pub views: SavedViews,
    /// The view that is to be shown.
    pub chosen_view: Option<String>,
    /// The index that terms such as `road:urban` ask.
    index: ListIndex,
    /// Names of groups that are shut.
    shut: HashSet<String>,
    /// Whether what arrived changes what is shown.
    stale: bool,
    /// Whether the planner was asked to drive those without an ego, for the order.
    driven: bool,
    /// How many were read.
    pub facts_read: usize,
    /// Columns of the longest name.
    pub longest: usize,
    /// Places on the screen that were last asked for before the others.
    pub urgent: Vec<usize>,
    /// Whether there are stored answers about any.
    pub answered: bool,
}

/// A line of the list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// The head of a group, by its place among the groups.
    Head(usize),
    /// A scenario, by its place in the rows, and the group it stands in.
    Scenario(usize, Option<usize>),
}

impl List {
    /// The list of these scenarios, which are all there are.
    pub fn fill(&mut self, found: SearchResults) {
        self.rows.clear();
        self.facts_read = 0;
        self.longest = 0;
        self.passed_over = found.passed_over;
        self.add(found.entries);
        self.found = true;
        self.arrange(false);
    }

    /// More scenarios were found.
    pub fn add(&mut self, entries: Vec<Entry>) {
        for entry in entries {
            let mut row = Row::new(entry, self.rows.len());
            row.own_tags = self.tags.tags_for(&row.entry.name).to_vec();
            self.longest = self.longest.max(row.entry.name.width());
            self.rows.push(row);
        }
        self.driven = false;
        self.stale = true;
    }

    /// A scenario was read.
    pub fn survey(&mut self, place: usize, facts: Result<Facts, String>) {
        let Some(row) = self.rows.get_mut(place) else {
            return;
        };
        self.facts_read += usize::from(row.facts.is_none());
        self.answered |= facts.as_ref().is_ok_and(|f| f.tally().count() > 0);
        // Words match tags, too.
        self.stale |= self.read.has_words() && facts.as_ref().is_ok_and(|f| !f.tags.is_empty());
        row.facts = Some(facts);
        row.look_up(self.index.ready().map(Arc::as_ref));
        self.stale |=
            self.read.needs_facts() || self.order.needs_facts() || self.grouping.needs_facts();
    }

    /// The user's tags are these.
    pub fn set_tags(&mut self, tags: Tags) {
        self.tags = tags;
        for row in &mut self.rows {
            row.own_tags = self.tags.tags_for(&row.entry.name).to_vec();
        }
        self.stale = true;
    }

    /// Puts what arrived in its place; the selection stays on what it is on.
    pub fn settle(&mut self) {
        if self.stale {
            self.arrange(true);
        }
    }

    /// The selected scenario's place in `rows`; nothing on the head of a group.
    #[must_use]
    pub fn current(&self) -> Option<usize> {
        match self.lines.get(self.selected)? {
            Line::Scenario(place, _) => Some(*place),
            Line::Head(_) => None,
        }
    }

    /// Adds a scenario at the end; gives its place.
    pub fn append(&mut self, entry: Entry) -> usize {
        self.add(vec![entry]);
        self.settle();
        self.rows.len() - 1
    }

    /// Selects the scenario at a place; a filter that hides it goes.
    pub fn show(&mut self, place: usize) {
        if !self.visible.contains(&place) {
            self.filtering = None;
            self.set_filter(String::new());
        }
        self.select(place);
    }

    /// Moves the selection; it stops at the ends.
    pub fn move_by(&mut self, lines: isize) {
        let last = self.lines.len().saturating_sub(1);
        self.selected = self.selected.saturating_add_signed(lines).min(last);
    }

    /// Selects a scenario; one that is hidden in a shut group is shown, one that the filter holds back is not selected.
    pub fn select(&mut self, place: usize) -> bool {
        let there = |line: &Line| matches!(line, Line::Scenario(p, _) if *p == place);
        if !self.lines.iter().any(there) && self.visible.contains(&place) {
            for (_, name) in self.grouping.groups_of(&self.rows[place]) {
                self.shut.remove(&name);
            }
            self.arrange(true);
        }
        let found = self.lines.iter().position(there);
        self.selected = found.unwrap_or(self.selected);
        found.is_some()
    }

    /// Whether the best match is to be opened once typing rests.
    #[must_use]
    pub fn waits(&self) -> bool {
        let filtering = self.filtering.as_ref();
        filtering.is_some_and(|filtering| filtering.rest.is_some())
    }

    /// Changes the filter; without one, the selected scenario stays selected.
    pub fn set_filter(&mut self, filter: String) {
        self.filter = filter;
        self.read_filter();
        // The best match is what one looks for while typing.
        self.arrange(self.filter.is_empty() || self.order != Order::Found);
    }

    /// The measure that it is sorted by.
    #[must_use]
    pub fn measure(&self) -> Option<&'static Measure> {
        match self.order {
            Order::Measure(measure) => Some(measure),
            _ => None,
        }
    }

    /// The measure that it is sorted by, where its values are not known with the facts.
    #[must_use]
    pub fn ranking(&self) -> Option<&'static Measure> {
        self.measure().filter(|m| !HEADLINE.contains(&m.id))
    }

    /// Every scenario, with its place.
    #[must_use]
    pub fn entries(&self) -> Vec<(usize, Entry)> {
        let entries = self.rows.iter().map(|row| row.entry.clone());
        entries.enumerate().collect()
    }

    /// Sorts anew, as far as what it sorts by is known; by the same again, the other way around.
    pub fn sort_by(&mut self, order: Order) {
        self.turned = self.order == order && !self.turned;
        self.set_order(order);
    }

    /// Selects the first scenario of an order that was chosen, once all that it sorts by is known; says whether it did.
    pub fn lead(&mut self) -> bool {
        let known = |row: &Row| match self.ranking() {
            Some(_) => row.value.is_some(),
            None => row.facts.is_some() && !(self.driven && row.lacks_ego() && row.value.is_none()),
        };
        if !self.leads || !self.found || !self.rows.iter().all(known) {
            return false;
        }
        self.leads = false;
        self.arrange(false);
        true
    }

    /// Sorts anew, in the same direction.
    pub fn set_order(&mut self, order: Order) {
        if self.order != order {
            self.driven = false;
            for row in &mut self.rows {
                row.value = None;
            }
        }
        self.order = order;
        self.read_filter();
        self.arrange(true);
    }

    /// This ego stands in where none is recorded.
    pub fn stand_in(&mut self, place: usize, ego: Option<StandInEgo>) {
        if let Some(row) = self.rows.get_mut(place) {
            row.stand_in = ego;
            self.stale = true;
        }
    }

    /// Scenarios without an ego that the order needs one of, with their places: once, when all are read.
    pub fn lacking_egos(&mut self) -> Vec<(usize, Entry)> {
        let by_danger = matches!(self.order, Order::Severity | Order::Measure(_));
        let read = self.found && self.facts_read >= self.rows.len();
        // With the values of a measure they are driven anyway.
        if !by_danger || !read || self.ranking().is_some() || self.driven {
            return Vec::new();
        }
        self.driven = true;
        let rows = self.rows.iter().enumerate();
        // Where the planner failed before, it is not asked again.
        rows.filter(|(_, row)| row.lacks_ego() && row.value.is_none())
            .map(|(place, row)| (place, row.entry.clone()))
            .collect()
    }

    /// Why some of the listed have no severity and no measures, where they lack an ego.
    #[must_use]
    pub fn without_ego(&self) -> Option<String> {
        let count = self.rows.iter().filter(|row| row.lacks_ego()).count();
        (count > 0).then(|| format!("no ego in {count}"))
    }

    /// Forgets what measures say, as after a change of thresholds.
    pub fn forget_values(&mut self) {
        for row in &mut self.rows {
            (row.value, row.stand_in) = (None, None);
        }
        self.driven = false;
        self.stale = true;
    }

    /// What a scenario is sorted by is known; the value of another order is too late, the ego is the same in all.
    pub fn rank(&mut self, order: &str, place: usize, ranked: Ranked) {
        if let Some(row) = self.rows.get_mut(place) {
            if self.order.id() == order {
                row.value = Some(ranked.value);
            }
            // The user's own drive stays.
            row.stand_in = row.stand_in.take().or(ranked.stand_in);
            self.stale = true;
        }
    }

    /// Groups anew.
    pub fn group_by(&mut self, grouping: Grouping) {
        self.grouping = grouping;
        self.shut.clear();
        self.arrange(true);
    }

    /// Shuts the selected group, or opens it; says whether a group is selected.
    pub fn toggle_group(&mut self) -> bool {
        let Some(Line::Head(group)) = self.lines.get(self.selected).copied() else {
            return false;
        };
        let name = self.groups[group].name.clone();
        if !self.shut.remove(&name) {
            self.shut.insert(name);
        }
        self.arrange(true);
        true
    }

    /// Filters, sorts and groups everything; `keep` keeps the selection where it is.
    fn arrange(&mut self, keep: bool) {
        self.stale = false;
        let selected = self.lines.get(self.selected).copied();
        let place = self.current().or(self.opened);
        let group = selected.and_then(|line| match line {
            Line::Head(group) | Line::Scenario(_, Some(group)) => self.groups.get(group),
            Line::Scenario(_, None) => None,
        });
        let name = group.map(|group| group.name.clone());
        let on_head = matches!(selected, Some(Line::Head(_)));

        (self.visible, self.matched) = self.passing();
        self.stand();

        let in_group = |line: &Line| match line {
            Line::Head(group) | Line::Scenario(_, Some(group)) => {
                Some(&self.groups[*group].name) == name.as_ref()
            }
            Line::Scenario(_, None) => name.is_none(),
        };
        let is_head = |line: &Line| matches!(line, Line::Head(_));
        let is_place = |line: &Line| matches!(line, Line::Scenario(p, _) if Some(*p) == place);
        let find = |what: &dyn Fn(&Line) -> bool| self.lines.iter().position(what);
        let same = if on_head {
            find(&|line| is_head(line) && in_group(line))
        } else {
            find(&|line| is_place(line) && in_group(line))
                .or_else(|| find(&is_place))
                .or_else(|| find(&|line| is_head(line) && in_group(line)))
        };
        let first = find(&|line| !is_head(line)).unwrap_or(0);
        self.selected = same.filter(|_| keep).unwrap_or(first);
    }

    /// Places of the scenarios that the filter lets through, in their order, and how its words matched.
    fn passing(&self) -> (Vec<usize>, WordMatch) {
        let mut matching = Matching::default();
        let mut score = |how: WordMatch| -> Vec<(u32, usize)> {
            let rows = self.rows.iter().enumerate();
            rows.filter_map(|(place, row)| Some((self.read.score(row, how, &mut matching)?, place)))
                .collect()
        };
        let (mut scored, mut how) = (score(WordMatch::Part), WordMatch::Part);
        if scored.is_empty() && self.read.has_words() {
            (scored, how) = (score(WordMatch::Fuzzy), WordMatch::Fuzzy);
        }
        let by_match = self.read.has_words() && self.order == Order::Found;
        scored.sort_by(|a, b| {
            let by_order = || {
                self.order
                    .compare(self.turned, &self.rows[a.1], &self.rows[b.1])
            };
            if by_match {
                b.0.cmp(&a.0).then_with(by_order)
            } else {
                by_order()
            }
        });
        (scored.into_iter().map(|(_, place)| place).collect(), how)
    }

    /// Makes the lines of the visible scenarios, with their groups.
    fn stand(&mut self) {
        self.groups.clear();
        self.lines.clear();
        if self.grouping == Grouping::None {
            let lines = self
                .visible
                .iter()
                .map(|&place| Line::Scenario(place, None));
            self.lines.extend(lines);
            return;
        }
        let mut members: BTreeMap<(u8, String), Vec<usize>> = BTreeMap::new();
        for &place in &self.visible {
            for group in self.grouping.groups_of(&self.rows[place]) {
                members.entry(group).or_default().push(place);
            }
        }
        for (group, ((_, name), places)) in members.into_iter().enumerate() {
            let shut = self.shut.contains(&name);
            let count = places.len();
            self.groups.push(Group { name, count, shut });
            self.lines.push(Line::Head(group));
            if !shut {
                let lines = places.iter().map(|&p| Line::Scenario(p, Some(group)));
                self.lines.extend(lines);
            }
        }
    }
}

/// The filter while it is typed.
#[derive(Debug, Clone)]
pub struct Filtering {
    /// Whether the whole text is selected: the first character that is typed replaces it.
    pub selected: bool,
    /// The text before.
    pub before: String,
    /// The selected line before.
    pub line: usize,
    /// The scenario and step that were open before.
    pub place: Option<Place>,
    /// Seconds until the best match is opened; none while it is open.
    pub rest: Option<f64>,
}

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

/// By what the list is grouped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Grouping {
    /// By nothing.
    #[default]
    #[strum(to_string = "nothing")]
    None,
    /// By country.
    Country,
    /// By folder.
    Folder,
    /// By tag; a scenario is under each of its tags.
    Tag,
    /// By what stored answers say.
    Verdict,
}

nearmiss_record::named!(Grouping);

impl Grouping {
    /// Whether it needs facts known only after a scenario was read.
    #[must_use]
    pub fn needs_facts(self) -> bool {
        matches!(self, Self::Country | Self::Tag | Self::Verdict)
    }

    /// The groups that a scenario is in: their place and their name, both for sorting.
    pub fn groups_of(self, row: &Row) -> Vec<(u8, String)> {
        const KNOWN: u8 = 0;
        const NOTHING: u8 = 8;
        const UNREAD: u8 = 9;
        let unread = || vec![(UNREAD, "not read yet".to_string())];
        let or = |name: &str, nothing: &str| match name {
            "" => vec![(NOTHING, nothing.to_string())],
            name => vec![(KNOWN, name.to_string())],
        };
        match self {
            Self::None => Vec::new(),
            Self::Country => match (row.country(), &row.facts) {
                ("", None) => unread(),
                (country, _) => or(country, "no country"),
            },
            Self::Folder => or(&row.entry.group, "no folder"),
            Self::Tag => {
                let mut tags: Vec<_> = row.tags().map(|tag| (KNOWN, tag.to_string())).collect();
                tags.sort();
                tags.dedup();
                match (tags.is_empty(), &row.facts) {
                    (false, _) => tags,
                    (true, None) => unread(),
                    (true, Some(_)) => vec![(NOTHING, "no tags".to_string())],
                }
            }
            Self::Verdict => match row.agreement() {
                Some(Agreement::Differ) => vec![(1, "answers differ".to_string())],
                Some(Agreement::Agree) => vec![(2, "answers agree".to_string())],
                Some(Agreement::Nothing) => vec![(NOTHING, "no answers".to_string())],
                None => unread(),
            },
        }
    }
}

/// A group that is shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// How many scenarios are in it.
    pub count: usize,
    /// Whether they are hidden.
    pub shut: bool,
}

#[cfg(test)]
mod tests;
