//! The moments that the map shows: now, and a second one beside it.

use nearmiss_base::geometry::{Placed, Point, Pose, Vector};
use nearmiss_drive::driver::DRIVERS;
use nearmiss_render::Variations;
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Headline;
use nearmiss_scene::scenario::Scene;
use ratatui::layout::{Position, Rect};

use crate::features::map::state::foresight::NO_FORESIGHT;
use crate::features::map::state::{Foresight, Measurement, On, Tape};
use crate::loaded::{CycleShown, Opened};
use crate::model::{Camera, Model};

/// Seconds before and after a moment over which the direction of the map is the mean, and at how many moments before.
const SMOOTH: f64 = 1.0;
const SAMPLES: i64 = 4;

/// The second map beside the first.
#[derive(Debug, Default)]
pub struct SecondMap {
    /// Whether the map is split in two.
    pub on: bool,
    /// The step that it is pinned to; `None` where it follows from what is open.
    pub pinned: Option<i64>,
    /// The driver that is shown, in place of another moment or the original of a variant.
    pub driver: bool,
    /// Predicted paths at its step.
    pub foresight: Foresight,
    /// Whether the map was zoomed out when it was split.
    pub widened: bool,
    /// Whether it was said that there is no room for it.
    pub warned: bool,
}

/// Why the second map shows its step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// The first contact.
    Contact,
    /// A second before the moment of the clock, which says most itself.
    Before,
    /// A second after it, where nothing is before.
    After,
    /// The worst moment of this obstacle.
    Worst(i64),
    /// The last step, where there is no ego and so nothing to be worst.
    End,
    /// The user chose it.
    Pinned,
    /// It is that of the clock.
    Clock,
}

/// A scene at a step, as a map shows it.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// What is shown.
    pub opened: &'a Opened,
    /// The time step.
    pub step: i64,
    /// Why it is this step.
    pub reason: Reason,
    /// Both motions of a variant's attackers.
    pub variations: Variations<'a>,
    /// Predicted paths at the step.
    pub foresight: &'a Foresight,
    /// Who drives, where two drives stand side by side.
    pub driven: Option<DrivenBy>,
}

/// Who drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DrivenBy {
    /// The ego of what is open: recorded, planned, or attacked.
    Ego,
    /// The ideal driver of the certificate, with this reaction time in seconds.
    Certificate(f64),
    /// A driver, by its place in [`DRIVERS`], with the closing speed at its contact, m/s.
    Driver(usize, Option<f64>),
}

impl DrivenBy {
    /// The driver's name, and a short one.
    #[must_use]
    pub fn driver(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Ego => None,
            Self::Certificate(_) => Some(("ideal driver", "ideal driver")),
            Self::Driver(place, _) => Some((DRIVERS[place].name, DRIVERS[place].id)),
        }
    }
}

impl<'a> Moment<'a> {
    /// Where the ego is, and where its lane leads on the whole, or it off the road: the map turns with it and is not to
    /// shake, and the road is to lie straight.
    #[must_use]
    pub fn ego(&self) -> Option<Pose> {
        let track = &self.opened.scene.as_ref()?.ego.track;
        let position = track.at(self.step)?.pose.position;
        let around = (SMOOTH / self.opened.scenario.dt()).round() as i64;
        let motions =
            track.during(&(self.step.saturating_sub(around)..=self.step.saturating_add(around)));
        let network = &self.opened.scenario.network;
        let few = motions.iter().step_by((around / SAMPLES).max(1) as usize);
        let directions = few.map(|(_, motion)| {
            let along = network.lane_heading(&motion.pose);
            let heading = along.unwrap_or(motion.pose.heading);
            Vector::new(heading.cos(), heading.sin())
        });
        let sum: Vector = directions.sum();
        let heading = sum.y.atan2(sum.x);
        Some(Pose { position, heading })
    }

    /// One that stands, at a step or the nearest that there is.
    fn still(
        opened: &'a Opened,
        step: i64,
        variations: Variations<'a>,
        driven: Option<DrivenBy>,
    ) -> Self {
        let steps = opened.steps();
        Self {
            opened,
            step: step.min(steps.end - 1).max(steps.start),
            reason: Reason::Clock,
            variations,
            foresight: &NO_FORESIGHT,
            driven,
        }
    }

    fn time(&self) -> f64 {
        self.step as f64 * self.opened.scenario.dt()
    }

    /// The planner's cycle.
    #[must_use]
    pub fn cycle(&self) -> Option<&'a CycleShown> {
        self.opened.planned.as_deref()?.cycle_at(self.step)
    }

    /// The scene with the recorded ego that stands beside the planned one.
    #[must_use]
    pub fn recorded(&self) -> Option<&'a Scene> {
        self.opened.planned.as_deref()?.recorded.as_deref()
    }

    /// What a tape measures.
    #[must_use]
    pub fn measured(&self, tape: &Tape) -> Measurement {
        tape.measure(self.opened, self.step)
    }

    /// What it is and when.
    #[must_use]
    pub fn title(&self) -> String {
        match self.driven {
            Some(driven) => {
                let [whole, ..] = self.driven_words(driven);
                format!("{whole} · {}", self.when())
            }
            None => format!("{} · {}", self.name(), self.when()),
        }
    }

    /// Whose drive it is, how it ends, and the gap to the nearest obstacle, in fewer and fewer words.
    #[must_use]
    pub fn driven_words(&self, driven: DrivenBy) -> [String; 4] {
        let (name, brief) = match driven {
            DrivenBy::Certificate(delay) => (format!("ideal driver {delay:.1} s"), "ideal driver"),
            DrivenBy::Driver(place, _) => (DRIVERS[place].name.into(), DRIVERS[place].id),
            DrivenBy::Ego => (self.ego_name(), self.whose()),
        };
        let verdict = self.ending();
        let series = self.opened.series.as_ref();
        let gap = series.and_then(|series| series.most_dangerous_at("distance", self.step));
        let [whole, short] = ["gap ", ""]
            .map(|word| gap.map_or(String::new(), |(_, gap)| format!(" · {word}{gap:.1} m")));
        [
            format!("{name}: {verdict}{whole}"),
            format!("{brief}: {verdict}{short}"),
            format!("{brief}: {verdict}"),
            brief.into(),
        ]
    }

    /// How the drive ends.
    #[must_use]
    pub fn ending(&self) -> String {
        let verdict = self.opened.collision.as_ref().map(|j| j.verdict.dangerous);
        match (self.driven, verdict) {
            (Some(DrivenBy::Driver(_, Some(speed))), _) => format!("X contact at {speed:.1} m/s"),
            (Some(DrivenBy::Driver(_, None)), _) | (_, Some(false)) => "no contact".into(),
            (_, Some(true)) => "X collision".into(),
            (_, None) => "no verdict".into(),
        }
    }

    /// Whose drive that of the ego is.
    #[must_use]
    pub fn whose(&self) -> &'static str {
        let opened = self.opened;
        let changed = opened.variant.as_ref().is_some_and(|shown| shown.changed);
        match (changed || opened.saved.is_some(), &opened.planned) {
            (true, _) => "attack",
            (false, Some(_)) => "planned",
            (false, None) => "recorded",
        }
    }

    /// The same, and the planner that drives against an attack, where that is another one than the built-in.
    fn ego_name(&self) -> String {
        if self.whose() != "attack" {
            return self.whose().into();
        }
        let planned = self.opened.planned.as_ref();
        let process = planned.and_then(|planned| planned.process.as_ref());
        let saved = self.opened.saved.as_ref();
        let saved = saved.map(|saved| saved.origin.planner());
        let name = process.map(|process| process.named()).or(saved);
        let other = name.filter(|name| name != "nearmiss");
        other.map_or("attack".into(), |name| {
            format!("attack on {}", visible(&name))
        })
    }

    /// Its time and step.
    #[must_use]
    pub fn when(&self) -> String {
        format!("{:.1} s · step {}", self.time(), self.step)
    }

    fn name(&self) -> String {
        let what = self
            .variations
            .shows_changed()
            .map(|changed| if changed { "variant" } else { "original" });
        match (self.reason, what) {
            (Reason::Clock, what) => what.unwrap_or("map").into(),
            (Reason::Contact, _) => "contact".into(),
            (Reason::Before, _) => "before".into(),
            (Reason::After, _) => "after".into(),
            (Reason::Worst(id), _) => format!("worst of {id}"),
            (Reason::End, _) => "end".into(),
            (Reason::Pinned, Some(what)) => format!("{what}, pinned"),
            (Reason::Pinned, None) => "pinned".into(),
        }
    }
}

/// The step a second before another one, or the first; beside the first, a second after it.
fn moment_to_compare(opened: &Opened, step: i64) -> (i64, Reason) {
    let second = (1.0 / opened.scenario.dt()).round().max(1.0) as i64;
    let steps = opened.steps();
    if step > steps.start {
        (step.saturating_sub(second).max(steps.start), Reason::Before)
    } else {
        (
            step.saturating_add(second).min(steps.end - 1),
            Reason::After,
        )
    }
}

/// The ego beside the driver that is shown, at the moment of their encounter; of a variant its original, too, all at the
/// moment that matters in the variant.
#[derive(Debug, Clone, Copy)]
pub struct Strip<'a> {
    /// The other in the encounter: of a variant the first attacker.
    pub other: i64,
    /// The original of a variant.
    pub original: Option<Moment<'a>>,
    /// The ego of what is open, or of the variant.
    pub ego: Moment<'a>,
    /// The driver, where its drive is known.
    pub driver: Option<Moment<'a>>,
}

impl Model {
    /// The variant that is open or beside whose original it is, that original, and both motions of the attackers in each.
    fn variant_pair(&self) -> Option<(&Opened, &Opened, [Variations<'_>; 2])> {
        let opened = self.opened.as_deref()?;
        Some(if let Some(shown) = self.variant() {
            let (hash, change) = self.made_of()?;
            let kept = self.generation.find(hash, change)?;
            let both = [true, false].map(|changed| shown.made.variations(changed));
            (&*kept.variant, &*kept.original, both)
        } else {
            let saved = opened.saved.as_ref()?;
            let (_, original) = saved.original.as_ref().ok()?;
            let both = [true, false].map(|changed| saved.variations(&opened.scenario, changed));
            (opened, &**original, both)
        })
    }

    /// The variant that is open or beside whose original it is.
    #[must_use]
    pub fn variant_opened(&self) -> Option<&Opened> {
        self.variant_pair().map(|(variant, ..)| variant)
    }

    /// The strip of the variant.
    #[must_use]
    pub fn variant_strip(&self) -> Option<Strip<'_>> {
        let (variant, original, both) = self.variant_pair()?;
        let other = both[0].iter().next()?.changed.id;
        let worst = variant.headline.as_ref().and_then(Headline::worst)?.step;
        let at = |opened, variations, driven| Moment::still(opened, worst, variations, driven);
        let (_, encounter) = self.encounter()?;
        let drive = self.drive_shown().filter(|_| encounter.step == worst);
        Some(Strip {
            other,
            original: Some(at(original, Variations::default(), None)),
            ego: at(variant, both[0], Some(DrivenBy::Ego)),
            driver: drive.map(|(opened, driven)| at(opened, both[0], Some(driven))),
        })
    }

    /// The strip of the encounter: of the moment that matters in a variant that of the variant.
    #[must_use]
    pub fn strip(&self) -> Option<Strip<'_>> {
        let (opened, encounter) = self.encounter()?;
        let (other, step) = (encounter.obstacle, encounter.step);
        let of_variant = self.variant_strip();
        if let Some(strip) = of_variant.filter(|strip| strip.ego.step == step) {
            return Some(strip);
        }
        let at = |opened, driven| Moment::still(opened, step, Variations::default(), Some(driven));
        let drive = self.drive_shown();
        Some(Strip {
            other,
            original: None,
            ego: at(opened, DrivenBy::Ego),
            driver: drive.map(|(opened, driven)| at(opened, driven)),
        })
    }

    /// The moment of the clock.
    #[must_use]
    pub fn moment(&self) -> Option<Moment<'_>> {
        let opened = self.opened.as_deref()?;
        let shown = opened.variant.as_ref();
        Some(Moment {
            opened,
            step: self.clock.step(),
            reason: Reason::Clock,
            variations: match (shown, &opened.saved) {
                (Some(shown), _) => shown.variations(),
                (None, Some(saved)) => saved.variations(&opened.scenario, true),
                (None, None) => Variations::default(),
            },
            foresight: &self.map.foresight,
            driven: self.driver_beside().map(|_| DrivenBy::Ego),
        })
    }

    /// The moment of the second map, where the map is split: of a variant the original, and the other way around, at
    /// the step of the clock; of any other scene its contact, or the worst moment of the picked obstacle, and where the
    /// clock is there, a second before. Where it is pinned, that step.
    #[must_use]
    pub fn second_moment(&self) -> Option<Moment<'_>> {
        let second = &self.map.second;
        let now = self.moment().filter(|_| second.on)?;
        let driver = self.driver_beside();
        let other = match driver {
            Some((opened, _)) => Some((opened, now.variations)),
            None => self.counterpart(),
        };
        let moment = other.map_or(now, |(opened, variations)| Moment {
            opened,
            variations,
            driven: driver.map(|(_, driven)| driven),
            ..now
        });
        let (step, reason) = match (second.pinned, other) {
            (Some(step), _) => (step, Reason::Pinned),
            (None, Some(_)) => (now.step, Reason::Clock),
            (None, None) => match self.telling_step(now.opened) {
                (step, _) if step == now.step => moment_to_compare(now.opened, step),
                telling => telling,
            },
        };
        // A drive may end before that of the other one.
        let steps = moment.opened.steps();
        Some(Moment {
            step: step.min(steps.end - 1).max(steps.start),
            reason,
            foresight: &second.foresight,
            ..moment
        })
    }

    /// The moment of the map at a position of the screen; elsewhere that of the clock.
    #[must_use]
    pub fn moment_at(&self, at: Position) -> Option<Moment<'_>> {
        let second = self.drawn.map_at(at).is_some_and(|map| map.second);
        let then = self.second_moment().filter(|_| second);
        then.or_else(|| self.moment())
    }

    /// The drive of the driver that is shown beside what is open.
    fn driver_beside(&self) -> Option<(&Opened, DrivenBy)> {
        let second = &self.map.second;
        let drive = self.drive_shown().filter(|_| second.on && second.driver);
        drive.filter(|_| self.is_encounter_here())
    }

    /// The original of the variant that is open, or the variant of its original.
    fn counterpart(&self) -> Option<(&Opened, Variations<'_>)> {
        let Some(shown) = self.variant() else {
            let opened = self.opened.as_deref()?;
            let saved = opened.saved.as_ref()?;
            let (_, original) = saved.original.as_ref().ok()?;
            return Some((&**original, saved.variations(&opened.scenario, false)));
        };
        let (hash, change) = self.made_of()?;
        let kept = self.generation.find(hash, change)?;
        // Another search may have replaced it meanwhile.
        let same = std::sync::Arc::ptr_eq(&kept.made, &shown.made);
        let other = if shown.changed {
            &kept.original
        } else {
            &kept.variant
        };
        same.then(|| (&**other, kept.made.variations(!shown.changed)))
    }

    /// The step that says most of a scene beside that of the clock.
    fn telling_step(&self, opened: &Opened) -> (i64, Reason) {
        let headline = opened.headline.as_ref();
        let worst = headline.and_then(Headline::worst);
        let picked = self
            .picked
            .zip(headline)
            .and_then(|(id, headline)| headline.worst_with(id));
        match (headline.is_some_and(Headline::collides), worst, picked) {
            (true, Some(contact), _) => (contact.step, Reason::Contact),
            (_, worst, picked) => match picked.or(worst) {
                Some(worst) => (worst.step, Reason::Worst(worst.obstacle)),
                None => (opened.steps().end - 1, Reason::End),
            },
        }
    }
}

/// The fewest columns and rows in which a map is of use.
const MIN_MAP_SIZE: (u16, u16) = (24, 6);

/// Two maps with a line between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Halves {
    /// The map of the clock's moment: on the left, or above.
    pub first: Rect,
    /// The line: a column, or a row.
    pub line: Rect,
    /// The map of the second moment.
    pub second: Rect,
}

impl Halves {
    /// Divides an area along a road that runs across the screen, or up; the other way where that leaves too little. `None`
    /// where there is no room for two.
    #[must_use]
    pub fn new(area: Rect, across: bool) -> Option<Self> {
        let (beside, above) = (Self::beside(area), Self::above(area));
        let order = if across {
            [above, beside]
        } else {
            [beside, above]
        };
        let mut both = order.into_iter();
        both.find(|halves| {
            halves.second.width >= MIN_MAP_SIZE.0 && halves.second.height >= MIN_MAP_SIZE.1
        })
    }

    fn beside(area: Rect) -> Self {
        let rest = area.width.saturating_sub(1);
        let part = |x, width| Rect { x, width, ..area };
        let first = part(area.x, rest - rest / 2);
        Self {
            first,
            line: part(first.right(), 1),
            second: part(first.right() + 1, rest / 2),
        }
    }

    fn above(area: Rect) -> Self {
        let rest = area.height.saturating_sub(1);
        let part = |y, height| Rect { y, height, ..area };
        let first = part(area.y, rest - rest / 2);
        Self {
            first,
            line: part(first.bottom(), 1),
            second: part(first.bottom() + 1, rest / 2),
        }
    }
}

/// Cells are at least so wide, metres, where the map chooses.
const NEAREST: f64 = 0.45;
/// And at most, where that shows both the ego and the other: beyond, bodies are single arrows.
const FARTHEST: f64 = 4.0;
/// Between two widths of cells: so the map does not zoom at every step.
const STEP: f64 = 1.1;
/// Around the middle of a body, metres, for the body and a part of its name.
const BODY_MARGIN: f64 = 5.0;
/// What is seen ahead of the ego, metres from its middle.
const AHEAD: f64 = 10.0;
/// At most, around a contact: both bodies are large.
const AT_CONTACT: f64 = 0.55;
/// Around the outlines of both, metres.
const CONTACT_MARGIN: f64 = 1.5;
/// The same in a strip, whose maps are low, and how wide cells are at most where that shows all of its egos.
const STRIP_MARGIN: f64 = 0.5;
const STRIP_FARTHEST: f64 = 0.9;

impl Model {
    /// Two maps in an area, along the road that the ego is on; without an ego as little elongated as possible.
    #[must_use]
    pub fn halves(&self, area: Rect) -> Option<Halves> {
        let wide = self.camera.is_wide((area.width, area.height));
        let across = match self.moment().and_then(|now| now.ego()) {
            Some(_) if self.camera.ego_up => wide,
            Some(ego) => ego.forward().x.abs() > ego.forward().y.abs(),
            None => !wide,
        };
        Halves::new(area, across)
    }

    /// The camera of a map of so many columns and rows at a moment. Until the user zooms, it shows the ego, and who
    /// touches it, else the picked obstacle or the most dangerous one, as near as possible.
    #[must_use]
    pub fn camera_of(&self, size: (u16, u16), moment: &Moment<'_>) -> Camera {
        let mut camera = self.camera.clone();
        camera.wide = camera.is_wide(size);
        if !camera.follow {
            camera.refit(size);
        }
        let (true, true, Some(ego)) = (camera.auto, camera.follow, moment.ego()) else {
            return camera;
        };
        camera.shift = Vector::zeros();
        let frame = camera.frame(Some(ego));
        let touching = self.touching(moment);
        let contact = touching.and_then(|id| contact_span(moment, id, &frame));
        let widest = if contact.is_some() {
            AT_CONTACT
        } else {
            f64::MAX
        };
        camera.cell = NEAREST.max((camera.least / f64::from(size.0.max(1))).min(widest));
        let others = self.spans_of_others(moment, &ego, &frame);
        let mut spans = contact.into_iter().chain(others);
        let _ = spans.any(|span| show(&mut camera, size, span, FARTHEST));
        camera
    }

    /// The camera of the maps of a strip, until the user zooms: as near as it shows the other and the egos of all drives,
    /// or else of the attack, and then as little beside the road as possible.
    #[must_use]
    pub fn camera_of_strip(&self, size: (u16, u16), strip: &Strip<'_>) -> Camera {
        let attack = &strip.ego;
        let mut camera = self.camera_of(size, attack);
        let (true, true, Some(ego)) = (camera.auto, camera.follow, attack.ego()) else {
            return camera;
        };
        (camera.cell, camera.shift) = (NEAREST, Vector::zeros());
        let frame = camera.frame(Some(ego));
        let body = |moment: &Moment<'_>, on| {
            let body = moment.opened.body_of(on, moment.step)?;
            Some(span(&body, &frame, STRIP_MARGIN))
        };
        let both = [On::Ego, On::Obstacle(strip.other)].map(|on| body(attack, on));
        let others = strip.original.iter().chain(&strip.driver);
        let egos = others.filter_map(|moment| body(moment, On::Ego));
        let Some(two) = both.into_iter().flatten().reduce(join) else {
            return camera;
        };
        let all = egos.fold(two, join);
        let mut spans = [(all, STRIP_FARTHEST), (two, FARTHEST)].into_iter();
        let shown = spans.find(|(span, farthest)| show(&mut camera, size, *span, *farthest));
        if let Some(((up, _), _)) = shown {
            let half = f64::from(size.1) * camera.row() / 2.0;
            let road = road_across(attack, &frame, camera.row() / 2.0, 2 * size.1);
            let shift = if road.1 - road.0 > 2.0 * half {
                camera.shift.x.max(road.0 + half).min(road.1 - half)
            } else {
                road.0.midpoint(road.1)
            };
            camera.shift.x = shift.max(up.1 - half).min(up.0 + half);
        }
        camera
    }

    /// Who touches the ego at a moment, or beside a contact, then.
    fn touching(&self, moment: &Moment<'_>) -> Option<i64> {
        let step = match moment.reason {
            Reason::Before | Reason::After => self.clock.step(),
            _ => moment.step,
        };
        let first = moment.opened.contact().filter(|first| first.step == step);
        let series = moment.opened.series.as_ref();
        let nearest = series.and_then(|series| series.most_dangerous_at("distance", step));
        let touching = nearest.filter(|(_, gap)| *gap <= 0.0);
        first
            .map(|first| first.obstacle)
            .or(touching.map(|(id, _)| id))
    }

    /// What a map has to show of the picked obstacle and the ego, or of the most dangerous one.
    fn spans_of_others(
        &self,
        moment: &Moment<'_>,
        ego: &Pose,
        frame: &Pose,
    ) -> impl Iterator<Item = Span> {
        let headline = moment.opened.headline.as_ref();
        let worst = headline.and_then(Headline::worst);
        let all = self.picked.into_iter().chain(worst.map(|w| w.obstacle));
        let ahead = frame.to_local(&(ego.position + ego.forward() * AHEAD));
        let around = move |to: f64, ahead: f64| {
            let (low, high) = (to.min(0.0) - BODY_MARGIN, to.max(0.0) + BODY_MARGIN);
            (low.min(ahead), high.max(ahead))
        };
        all.filter_map(move |id| {
            let motion = moment.opened.motion_of(On::Obstacle(id), moment.step)?;
            let to = frame.to_local(&motion.pose.position);
            Some((around(to.x, ahead.x), around(to.y, ahead.y)))
        })
    }

    /// Takes over what the map showed last, so that keys and the mouse start from there.
    pub fn settle_camera(&mut self) {
        if let Some(now) = self.moment() {
            let camera = self.camera_of(self.drawn.map_size(), &now);
            self.camera = camera;
        }
    }
}

/// From where to where, metres from the ego.
type Range = (f64, f64);

/// What a map has to show: up the map, and to its left.
type Span = (Range, Range);

/// Zooms out and moves a map of so many columns and rows, as little as shows a span; false where its cells would be wider
/// than so many metres.
fn show(camera: &mut Camera, size: (u16, u16), (up, left): Span, farthest: f64) -> bool {
    let (columns, rows) = (f64::from(size.0.max(1)), f64::from(size.1.max(1)));
    let needs = ((left.1 - left.0) / columns).max((up.1 - up.0) / (rows * camera.aspect));
    let steps = (needs / camera.cell).log(STEP).ceil().max(0.0);
    let cell = camera.cell * STEP.powf(steps);
    if !cell.is_finite() || cell > farthest.max(camera.cell) {
        return false;
    }
    camera.cell = cell;
    let aside = |(low, high): Range, length: f64| {
        (high - length / 2.0).max(0.0) + (low + length / 2.0).min(0.0)
    };
    camera.shift = Vector::new(
        aside(up, rows * camera.row()),
        aside(left, columns * camera.cell),
    );
    true
}

/// Both spans.
fn join(a: Span, b: Span) -> Span {
    let join = |a: Range, b: Range| (a.0.min(b.0), a.1.max(b.1));
    (join(a.0, b.0), join(a.1, b.1))
}

/// A body with a margin around it.
fn span(body: &Placed<'_>, frame: &Pose, margin: f64) -> Span {
    let along = |axis: Vector| {
        let (low, high) = body.extent(&frame.position, &axis);
        (low - margin, high + margin)
    };
    (along(frame.forward()), along(frame.left()))
}

/// How far the road reaches down and up the map from the ego, in steps of so many metres; infinite beyond so many steps.
fn road_across(moment: &Moment<'_>, frame: &Pose, step: f64, most: u16) -> Range {
    let network = &moment.opened.scenario.network;
    let edge = |side: f64| {
        let mut steps = (1..=most).map(|i| side * step * f64::from(i));
        let is_off = |up: &f64| {
            let at = frame.to_world(&Point::new(*up, 0.0));
            network.lanelets_at(&at).is_empty()
        };
        steps.find(is_off).unwrap_or(side * f64::INFINITY)
    };
    (edge(-1.0), edge(1.0))
}

/// What a map has to show of a contact: both bodies.
fn contact_span(moment: &Moment<'_>, obstacle: i64, frame: &Pose) -> Option<Span> {
    let [ego, other] = [On::Ego, On::Obstacle(obstacle)].map(|on| {
        let body = moment.opened.body_of(on, moment.step)?;
        Some(span(&body, frame, CONTACT_MARGIN))
    });
    Some(join(ego?, other?))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn maps_stand_beside_or_above_each_other_and_fill_the_area() {
        for (width, height, across, beside) in [
            (72, 28, false, true),
            (72, 28, true, false),
            (41, 15, true, false),
            (41, 15, false, false),
            (60, 10, true, true),
        ] {
            let area = Rect::new(3, 2, width, height);
            let halves = Halves::new(area, across).unwrap();
            assert_eq!(halves.first.y == halves.second.y, beside, "{area}");
            let parts = [halves.first, halves.line, halves.second];
            let cells: u32 = parts.iter().map(|part| part.area()).sum();
            assert_eq!(cells, area.area());
            assert!(parts.iter().all(|part| area.union(*part) == area));
            assert!(!halves.first.intersects(halves.second));
            assert_eq!(halves.line.width.min(halves.line.height), 1);
        }
        for (width, height) in [(0, 0), (1, 1), (41, 12), (30, 11), (200, 5)] {
            assert_eq!(Halves::new(Rect::new(0, 0, width, height), true), None);
        }
    }
}
