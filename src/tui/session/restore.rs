//! Captures the state of the workbench as a session, and restores it at the next start.

use std::time::Duration;

use crate::action::Action;
use crate::features::timeline;
use crate::message::{Effect, Msg};
use crate::model::{Grouping, IndexChoice, Model, Order, Pane};
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::session::{Override, SavedLocation, SavedScenario, Session, View};
use crate::update::{open, open_current};
use nearmiss_ask::prompts::Techniques;
use nearmiss_base::geometry::{Point, Vector};
use nearmiss_base::system::crash;
use nearmiss_formats::Entry;
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
use nearmiss_scene::metrics::measure;
use nearmiss_scene::verdict::Task;

/// The current session.
#[must_use]
pub fn capture(model: &Model) -> Session {
    let rows = model.list.rows.iter().map(|row| &row.entry);
    let marked = rows.filter(|entry| model.marks.has(entry));
    let mut marks: Vec<SavedLocation> = marked.map(|entry| lies(model, entry)).collect();
    marks.extend(model.recall.marks.iter().cloned());
    marks.sort();
    let config = &model.config;
    Session {
        paths: model.recall.paths.clone(),
        task: model.task.name().into(),
        frame: model.frame.name().into(),
        techniques: model
            .techniques_chosen
            .then(|| model.techniques.to_string()),
        tools: Override::chosen(on(model.tools), Some(&on(config.tools).into()), ""),
        model: Override::chosen(&model.model, config.model.as_ref(), judge::MODEL),
        theme: Override::chosen(&model.look.chosen, config.theme.as_ref(), "auto"),
        focus: model.focus.name().into(),
        zoomed: model.zoomed,
        filter: model.list.filter.clone(),
        sort: (model.list.order.id().into(), model.list.turned),
        group: model.list.grouping.name().into(),
        plot: model.plot.measure.id.into(),
        marks,
        sizes: model.look.sizes,
        layers: model.map.layers.clone(),
        // Beside a variant it showed what does not come back.
        split_map: model.map.second.on && model.variant().is_none(),
        experiments: model.experiment.recent.clone(),
        index: index_of(model),
        opened: opened_of(model).or_else(|| model.recall.wanted.clone()),
        ..Session::default()
    }
}

/// A switch, as sessions have it.
fn on(switch: bool) -> &'static str {
    if switch { "on" } else { "off" }
}

/// The index that was chosen instead of the configured one.
fn index_of(model: &Model) -> Option<Override> {
    let configured = model
        .index
        .configured
        .as_deref()
        .map(|folder| IndexChoice::text(Some(folder)));
    let chosen = IndexChoice::text(model.index.folder.as_deref());
    Override::chosen(&chosen, configured.as_ref(), "")
}

fn opened_of(model: &Model) -> Option<SavedScenario> {
    model.opened.as_ref()?;
    if model.opening.is_some() {
        // The screen shows another scenario.
        return model.recall.kept.as_ref()?.opened.clone();
    }
    let entry = &model.list.rows.get(model.list.opened?)?.entry;
    let camera = &model.camera;
    Some(SavedScenario {
        scenario: lies(model, entry),
        ego: model.taken,
        step: model.variant().is_none().then(|| model.clock.step()),
        picked: model.picked,
        pinned: model.map.second.pinned,
        camera: View {
            cell: camera.cell,
            center: [camera.center.x, camera.center.y],
            shift: [camera.shift.x, camera.shift.y],
            follow: camera.follow,
            up: Some(camera.up),
            ego_up: camera.ego_up,
            auto: camera.auto,
        },
    })
}

fn lies(model: &Model, entry: &Entry) -> SavedLocation {
    SavedLocation::from_entry(entry, &model.recall.here)
}

/// Restores a session before anything is open; settings no longer known keep their defaults. An obstacle as the ego is
/// restored only if no other ego was chosen.
pub fn restore(model: &mut Model, session: Session, ego_chosen: bool) {
    model.recall.kept = Some(Box::new(session.clone()));
    model.task = Task::parse(&session.task).unwrap_or(model.task);
    model.frame = Frame::parse(&session.frame).unwrap_or(model.frame);
    if let Some(Ok(techniques)) = session.techniques.as_deref().map(Techniques::parse) {
        model.techniques = techniques;
        model.techniques_chosen = true;
    }
    let chosen = |instead: &Option<Override>, of: Option<&String>| {
        let still = instead.as_ref()?.still(of)?;
        Some(still.to_string())
    };
    if let Some(tools) = chosen(&session.tools, Some(&on(model.config.tools).into())) {
        model.tools = tools == on(true);
    }
    if let Some(id) = chosen(&session.model, model.config.model.as_ref()) {
        model.model = id;
    }
    if let Some(name) = chosen(&session.theme, model.config.theme.as_ref())
        && let Ok(theme) = model.look.theme(&name)
    {
        model.theme = theme;
        model.look.chosen = name;
    }
    let configured = model
        .index
        .configured
        .as_deref()
        .map(|folder| IndexChoice::text(Some(folder)));
    if let Some(folder) = chosen(&session.index, configured.as_ref()) {
        model.index.folder = (!folder.is_empty()).then(|| folder.into());
    }
    let mut panes = Pane::ALL.into_iter();
    model.focus = panes
        .find(|p| p.name() == session.focus)
        .unwrap_or(model.focus);
    model.zoomed = session.zoomed;
    model.look.sizes = session.sizes;
    model.map.layers = session.layers;
    model.map.second.on = session.split_map;
    model.experiment.recent = session.experiments;
    if let Some(plotted) = measure(&session.plot) {
        model.plot.measure = plotted;
    }
    let (sort, turned) = session.sort;
    if let Some(order) = Order::parse(&sort) {
        model.list.set_order(order);
        model.list.turned = turned;
    }
    if let Some(grouping) = Grouping::parse(&session.group) {
        model.list.group_by(grouping);
    }
    model.list.set_filter(session.filter);
    model.recall.marks = session.marks.into_iter().collect();
    let opened = session.opened.map(|opened| SavedScenario {
        ego: opened.ego.filter(|_| !ego_chosen),
        ..opened
    });
    model.recall.wanted = opened;
}

/// Scenarios were found: those that were marked last time are marked again, and the one that was open is opened as soon
/// as it is there; where it is not, the selected one.
pub fn open_found(model: &mut Model) -> Vec<Effect> {
    let again = find_again(model);
    if model.list.opened.is_some() {
        return Vec::new();
    }
    model.list.settle();
    match (again, &model.recall.wanted) {
        (Some(place), Some(wanted)) => {
            let ego = wanted.ego;
            // A scenario hidden by the filter is open all the same, as before.
            model.list.select(place);
            if held_back(model, place) {
                model.recall.wanted = None;
                return Vec::new();
            }
            open(model, place, ego)
        }
        (None, Some(_)) if !model.list.found => Vec::new(),
        _ => {
            model.recall.wanted = None;
            open_current(model)
        }
    }
}

/// Looks through the scenarios that are new in the list; gives the place of the one that was open last time.
fn find_again(model: &mut Model) -> Option<usize> {
    let recall = &mut model.recall;
    let new = std::mem::replace(&mut recall.seen, model.list.rows.len());
    if recall.wanted.is_none() && recall.marks.is_empty() {
        return None;
    }
    let mut found = None;
    for (place, row) in model.list.rows.iter().enumerate().skip(new) {
        let lies = SavedLocation::from_entry(&row.entry, &recall.here);
        if recall.wanted.as_ref().is_some_and(|w| w.scenario == lies) {
            found = Some(place);
        }
        if recall.marks.remove(&lies) {
            model.marks.toggle(&row.entry);
        }
    }
    if model.list.found {
        recall.marks.clear();
    }
    found
}

/// Holds back a scenario that ended the program when it was last open: it is not opened until the user asks for it;
/// says so, and focuses the list. Returns whether it did.
pub fn held_back(model: &mut Model, place: usize) -> bool {
    let entry = model.list.rows[place].entry.clone();
    if model.list.opened == Some(place) || !crash::is_held(&lies(model, &entry).subject()) {
        return false;
    }
    let key = model.look.key(Action::Choose);
    let words = format!(
        "{}: the program crashed while opening or showing this scenario; {key} opens it anyway",
        entry.name
    );
    if model.opened.is_none() {
        model.open_error = Some(words.clone());
    }
    model.focus = Pane::Scenarios;
    model.tell(words);
    true
}

/// The user opens the selected scenario, whatever it did before.
pub fn released(model: &mut Model) {
    if let Some(place) = model.list.current() {
        crash::release(&lies(model, &model.list.rows[place].entry).subject());
    }
}

/// Whether what is being opened is what was open last time.
#[must_use]
pub fn is_wanted(model: &Model) -> bool {
    model.recall.wanted.is_some()
}

/// A scenario is about to be opened: where it is another one, the last session's is wanted no longer.
pub fn opening(model: &mut Model, entry: &Entry) {
    let lies = lies(model, entry);
    let wanted = model.recall.wanted.as_ref();
    if wanted.is_some_and(|wanted| wanted.scenario != lies) {
        model.recall.wanted = None;
    }
}

/// A scenario was opened: if it is that of the last session, it is looked at as it was.
pub fn opened(model: &mut Model) {
    let Some(wanted) = model.recall.wanted.take() else {
        return;
    };
    let Some(step) = wanted.step else {
        return;
    };
    model.clock.go(step);
    let there = |id: &i64| {
        let opened = model.opened.as_ref();
        opened.is_some_and(|opened| opened.scenario.obstacle(*id).is_some())
    };
    model.picked = wanted.picked.filter(there);
    model.map.second.pinned = wanted.pinned;
    let View {
        cell,
        center,
        shift,
        follow,
        up,
        ego_up,
        auto,
    } = wanted.camera;
    let up = up.unwrap_or(model.camera.up);
    let numbers = [cell, center[0], center[1], shift[0], shift[1], up];
    if numbers.iter().all(|n| n.is_finite()) && cell > 0.0 {
        let camera = &mut model.camera;
        camera.cell = cell;
        // Within what can be zoomed to.
        camera.scale(1.0);
        camera.center = Point::new(center[0], center[1]);
        camera.shift = Vector::new(shift[0], shift[1]);
        camera.follow = follow;
        camera.up = up;
        camera.ego_up = ego_up;
        camera.auto = auto;
    }
    timeline::stepped(model);
    model.refresh();
}

/// Something happened that a session may remember.
pub fn note(model: &mut Model, msg: &Msg) {
    let by_hand = matches!(msg, Msg::Key(_) | Msg::Mouse(_) | Msg::Paste(_));
    model.recall.changed |= by_hand;
}

/// Something changed: it is kept after a while.
pub fn remember(model: &mut Model) -> Option<Effect> {
    let recall = &mut model.recall;
    let due = recall.on && recall.changed && !recall.asked;
    recall.asked |= due;
    due.then_some(KeepSessionLater.into())
}

/// Keeps what the workbench looks like, if that is another look than was kept last.
pub fn keep(model: &mut Model) -> Vec<Effect> {
    model.recall.asked = false;
    // Playback moves on by itself.
    model.recall.changed = model.clock.playing;
    if !model.recall.on {
        return Vec::new();
    }
    let session = Box::new(capture(model));
    if model.recall.kept.as_ref() == Some(&session) {
        return Vec::new();
    }
    model.recall.kept = Some(session.clone());
    vec![KeepSession(session).into()]
}

/// How long after a change the session is saved: what a killed program loses.
const SESSION_DELAY: Duration = Duration::from_secs(2);

/// Replies after a while: the session is to be kept.
#[derive(Debug)]
pub struct KeepSessionLater;

impl Request for KeepSessionLater {
    type Reply = ();

    fn perform(self, _: &mut Services, replies: Replies<Self>) {
        tokio::spawn(async move {
            tokio::time::sleep(SESSION_DELAY).await;
            replies.send(());
        });
    }

    fn reply(model: &mut Model, (): ()) -> Vec<Effect> {
        keep(model)
    }
}

/// Keeps what the workbench looks like for the next start.
#[derive(Debug)]
pub struct KeepSession(pub Box<Session>);

impl Request for KeepSession {
    type Reply = ();

    // At once and not in the background: the program may be about to end.
    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        if let Err(error) = super::file::write(&services.folders.sessions(), &self.0) {
            replies.complain(format!("{error}; the session is not kept"));
        }
    }
}
