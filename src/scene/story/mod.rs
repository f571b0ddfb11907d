//! What happened: the moment that matters of a recording in at most four sentences, each of facts with numbers.
//!
//! A fact says no more than what can be recomputed from the recorded states of the ego and of the other road user: where
//! they are, how fast, how much they turn and brake, when their ways overlap, how near they come. It is of 5 s before
//! the moment to 2 s after it; an action in it is told whole. Lowest and nearest are of that time, and of the whole
//! recording. `Story::sentences` has the facts as
//! data with their words, for pages, maps and programs.

mod actions;
mod words;

use std::ops::RangeInclusive;

use nearmiss_base::geometry::angle_between;
use serde::Serialize;

use crate::metrics::{
    Contact, Context, CriticalMoment, Direction, Encounter, Headline, Measure, measure,
};
use crate::scenario::{ObstacleType, Track, Window};
pub use actions::{Action, Beside};
pub(crate) use actions::{Braking, brakings};
use actions::{Doing, Drive, NOTABLE, is_change};

/// So long before the moment a story begins, seconds.
const BEFORE: f64 = 5.0;

/// So long after it a story ends, seconds.
const AFTER: f64 = 2.0;

/// That one does not brake is told of at least so long, seconds.
const WHILE: f64 = 0.5;

/// A fall of the speed so long before the time to collision gets short still belongs to it, seconds.
const SHORTLY: f64 = 1.0;

/// What goes on in these last seconds before the moment, or the contact, tells more.
const LATE: f64 = 2.0;

/// Who is slower has been brought to it by what it did before, m/s.
const CREEPING: f64 = 1.0;

/// So many actions of one are told.
const MOST: usize = 3;

/// Who is slower stands, m/s.
const STANDING: f64 = 0.5;

/// A time to collision from here on is short, seconds.
const SHORT: f64 = 3.0;

/// Who changes its heading by this turns, radians: 15°.
const TURN: f64 = 0.262;

/// Directions that are nearer to each other do not cross, radians: 30°.
const CROSSING: f64 = 0.524;

/// What happened around the moment that matters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Story {
    /// Id of the ego.
    pub ego: i64,
    /// Id of the other road user.
    pub obstacle: i64,
    /// Its type.
    pub kind: ObstacleType,
    /// First and last second that it is about.
    pub span: (f64, f64),
    /// At most four.
    pub sentences: Vec<Sentence>,
}

/// A sentence and what it says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sentence {
    /// In plain English.
    pub text: String,
    /// Its facts, in the order of the text.
    pub facts: Vec<Fact>,
}

/// Whom a fact is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Who {
    /// The ego.
    Ego,
    /// The other road user.
    Other,
}

/// Where the other moves to, seen from the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Course {
    /// What is there is a region that it may be in, which has no motion.
    Region,
    /// It stands.
    Stands,
    /// Within 45° of the ego's heading.
    SameWay,
    /// Within 45° of the opposite.
    Towards,
    /// In between, to the left.
    ToTheLeft,
    /// In between, to the right.
    ToTheRight,
}

/// A fact with its numbers: seconds since time step 0, metres, m/s, m/s², degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "fact", rename_all = "snake_case")]
pub enum Fact {
    /// How both move at a time.
    Begin {
        /// When.
        time: f64,
        /// Speed of the ego.
        ego_speed: f64,
        /// Speed of the other.
        other_speed: f64,
        /// Distance of the bodies.
        distance: f64,
        /// Where the other is, seen from the ego's body.
        #[serde(serialize_with = "direction_name")]
        place: Direction,
        /// Where the other moves to.
        course: Course,
        /// Where it moves to after it stood or crept, if that is elsewhere.
        later: Option<Course>,
    },
    /// What one does.
    Does {
        /// Who.
        who: Who,
        /// From then on.
        from: f64,
        /// Until then.
        to: f64,
        /// What.
        #[serde(flatten)]
        action: Action,
    },
    /// One leaves the place where both ways overlap before the other comes there.
    Pass {
        /// Who is there first.
        first: Who,
        /// When it leaves.
        left: f64,
        /// When the other comes.
        entered: f64,
    },
    /// The lowest time to collision.
    LowestTtc {
        /// When.
        time: f64,
        /// Seconds.
        seconds: f64,
        /// Whether that is outside of the time of the story: of the whole recording.
        is_outside: bool,
        /// Whether there is no later step with both.
        is_last: bool,
    },
    /// Between these times the time to collision is at most 3 s.
    ShortTtc {
        /// From then on; it is not at the step before, if there is one.
        time: f64,
        /// Until it is lowest.
        until: f64,
    },
    /// At no step both would touch within 10 s if they went straight on.
    NoCourse,
    /// The first contact.
    Contact {
        /// When: the first step at which they touch, or on the way to which.
        time: f64,
        /// The speed of one relative to the other.
        closing_speed: f64,
        /// The same by their places, where recorded speeds are far off these.
        by_places: Option<f64>,
        /// Whether what is touched is a region that the other may be in.
        is_possible: bool,
    },
    /// The smallest distance, at a step.
    Nearest {
        /// When.
        time: f64,
        /// Of the bodies.
        distance: f64,
        /// Where the other is, seen from the ego's body.
        #[serde(serialize_with = "direction_name")]
        place: Direction,
        /// Whether that is outside of the time of the story: of the whole recording.
        is_outside: bool,
    },
    /// Between the steps around the smallest distance, straight ways would overlap by less than is certain there.
    Uncertain {
        /// By so much.
        overlap: f64,
    },
    /// Recorded speeds of one in the time of the story are far off those by its places.
    SpeedsOff {
        /// Whose.
        who: Who,
        /// By up to, m/s.
        by: f64,
    },
}

// The signature is serde's.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn direction_name<S: serde::Serializer>(place: &Direction, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(place.name())
}

impl Story {
    /// The story of the moment that matters; nothing where no other road user is ever there with the ego.
    #[must_use]
    pub fn new(context: &Context<'_>) -> Option<Self> {
        let headline = Headline::from_context(context);
        Self::of_moment(context, headline.worst()?)
    }

    /// The story of a moment.
    #[must_use]
    pub fn of_moment(context: &Context<'_>, moment: &CriticalMoment) -> Option<Self> {
        let mut all = context.participants().iter();
        let participant = all.position(|other| other.obstacle.id == moment.obstacle)?;
        let told = Telling::new(context, participant, moment.step)?;
        let kind = context.participants()[participant].obstacle.kind;
        let subject = words::name(kind, moment.obstacle);
        let facts = [told.begin(), told.other(), told.nearness(), told.ego()];
        let sentences = facts.into_iter().filter(|facts| !facts.is_empty());
        Some(Self {
            ego: context.scene().ego.id,
            obstacle: moment.obstacle,
            kind,
            span: told.span(),
            sentences: sentences
                .map(|facts| Sentence {
                    text: words::sentence(&subject, &facts),
                    facts,
                })
                .collect(),
        })
    }

    /// All sentences, a space between two.
    #[must_use]
    pub fn text(&self) -> String {
        let texts = self.sentences.iter().map(|sentence| sentence.text.as_str());
        texts.collect::<Vec<_>>().join(" ")
    }
}

/// What a story is told of.
struct Telling<'c, 's> {
    context: &'c Context<'s>,
    participant: usize,
    /// The steps at which both are there.
    common: Vec<i64>,
    /// Those of them that the story is about, without a gap.
    window: Window,
    /// The step that matters most: the first contact, else the moment.
    moment: i64,
    ego: Drive,
    other: Drive,
}

impl<'c, 's> Telling<'c, 's> {
    fn new(context: &'c Context<'s>, participant: usize, moment: i64) -> Option<Self> {
        let scene = context.scene();
        let there = |step: &i64| context.encounter(participant, *step).is_some();
        let common: Vec<i64> = context.steps().filter(there).collect();
        let dt = scene.scenario.dt();
        let count = |seconds: f64| (seconds / dt).round() as i64;
        let (before, after) = (count(BEFORE), count(AFTER));
        // A contact ends what is worth telling.
        let contact = context.contacts(participant).first();
        let end = contact.map_or(moment + after, |contact| contact.step.max(moment));
        let first = (moment - before..=moment).rev().take_while(there).last()?;
        let last = (moment..=end).take_while(there).last()?;
        let window = Window::within(&(first..last + 1), last, usize::MAX);
        // Who never moves is at any step; what it does is told of its track, which ends.
        let other = context.participants()[participant].obstacle.track();
        let drive = |track: &Track| {
            let ends = |step: &i64| contact.is_none() || *step <= end;
            let motion = |step| track.at(Some(step).filter(ends)?).copied();
            Drive::new(motion, window.first(), dt, &scene.scenario.network)
        };
        let drives = (drive(&scene.ego.track), drive(other));
        Some(Self {
            context,
            participant,
            common,
            window,
            moment: contact.map_or(moment, |_| end),
            ego: drives.0,
            other: drives.1,
        })
    }

    fn encounter(&self, step: i64) -> Option<Encounter<'_>> {
        self.context.encounter(self.participant, step)
    }

    fn time(&self, step: i64) -> f64 {
        self.context.scene().time_of(step)
    }

    fn span(&self) -> (f64, f64) {
        (
            self.time(self.window.first()),
            self.time(self.window.last()),
        )
    }

    /// How both move at the first step.
    fn begin(&self) -> Vec<Fact> {
        let first = self.window.first();
        let Some(encounter) = self.encounter(first) else {
            return Vec::new();
        };
        vec![Fact::Begin {
            time: self.span().0,
            ego_speed: encounter.ego.velocity.abs(),
            other_speed: encounter.other.velocity.abs(),
            distance: encounter.distance(),
            place: encounter.relation().direction,
            course: self.course(first, &encounter),
            later: self.later_course(first, &encounter),
        }]
    }

    /// Where one moves to later that stands or creeps at a step, if that is elsewhere.
    fn later_course(&self, first: i64, encounter: &Encounter<'_>) -> Option<Course> {
        if encounter.other.velocity.abs() >= CREEPING {
            return None;
        }
        let before = self.course(first, encounter);
        let mut courses = self.window.steps().filter_map(|step| {
            // Its way is seen once it moves.
            self.other.next_way(step)?;
            Some(self.course(step, &self.encounter(step)?))
        });
        courses.find(|course| *course != Course::Stands && *course != before)
    }

    /// Where the other moves to at a step, as seen from the ego.
    fn course(&self, step: i64, encounter: &Encounter<'_>) -> Course {
        use std::f64::consts::FRAC_PI_4;
        if encounter.is_with_occupancy() {
            return Course::Region;
        }
        if encounter.other.velocity.abs() < STANDING {
            return Course::Stands;
        }
        // Headings of one that creeps may be those of noise.
        let way = self.other.next_way(step);
        let way = way.unwrap_or_else(|| encounter.other.velocity_vector());
        let angle = angle_between(encounter.ego.pose.heading, way.y.atan2(way.x));
        match angle.abs() {
            angle if angle <= FRAC_PI_4 => Course::SameWay,
            angle if angle >= 3.0 * FRAC_PI_4 => Course::Towards,
            _ if angle > 0.0 => Course::ToTheLeft,
            _ => Course::ToTheRight,
        }
    }

    /// What the other does.
    fn other(&self) -> Vec<Fact> {
        // A region has no motion.
        if self.context.participants()[self.participant]
            .obstacle
            .is_set_based()
        {
            return Vec::new();
        }
        let mut told = self.actions(&self.other, self.late(None));
        let pass = self.pass();
        if told.is_empty() && pass.is_none() {
            told.extend(self.keeps_on(&self.other, (self.window.first(), self.window.last())));
        }
        let told = told.iter().map(|doing| self.does(Who::Other, doing));
        told.chain(pass).collect()
    }

    /// The steps in which what goes on tells most: shortly before the moment, and before what is lowest.
    fn late(&self, short: Option<(i64, i64)>) -> (i64, i64) {
        let told = self.window.steps();
        let nearest = self.lowest(&told, |step| Some(self.encounter(step)?.distance()));
        let lowest = [self.lowest_ttc(&told), nearest].into_iter().flatten();
        let steps = lowest.map(|(step, _)| step).chain([self.moment]);
        let (first, last) = steps.fold((i64::MAX, i64::MIN), |(first, last), step| {
            (first.min(step), last.max(step))
        });
        let since = first - self.count(LATE);
        (short.map_or(since, |(short, _)| short.min(since)), last)
    }

    fn count(&self, seconds: f64) -> i64 {
        (seconds / self.context.scene().scenario.dt()).round() as i64
    }

    /// The steps of which it is told what one does: also the time before of who stands or creeps all along.
    fn told_steps(&self, drive: &Drive) -> (i64, i64) {
        let (first, last) = (self.window.first(), self.window.last());
        let creeps = drive.speeds((first, last)).1 < CREEPING;
        (
            if creeps {
                first - self.count(BEFORE)
            } else {
                first
            },
            last,
        )
    }

    /// What most there is to tell of what one does in the time of the story, in its order.
    fn actions(&self, drive: &Drive, late: (i64, i64)) -> Vec<Doing> {
        let (first, last) = self.told_steps(drive);
        let is_told = |doing: &&Doing| {
            let (from, to) = doing.steps;
            from <= last && (from >= first || to - first >= self.count(WHILE))
        };
        let mut told: Vec<Doing> = drive.doings.iter().filter(is_told).copied().collect();
        told.sort_by(|a, b| b.weight(late).total_cmp(&a.weight(late)));
        told.truncate(MOST);
        told.sort_by_key(|doing| doing.steps);
        told
    }

    fn does(&self, who: Who, doing: &Doing) -> Fact {
        Fact::Does {
            who,
            from: self.time(doing.steps.0),
            to: self.time(doing.steps.1),
            action: doing.action,
        }
    }

    /// The speeds of one who does nothing else, if it moves.
    fn keeps_on(&self, drive: &Drive, steps: (i64, i64)) -> Option<Doing> {
        let (low, high) = drive.speeds(steps);
        let is_steady = high < CREEPING || !is_change(high - low, high);
        let is_told = high >= STANDING && steps.0 < steps.1 && is_steady;
        let action = Action::KeepOn { low, high };
        is_told.then_some(Doing { steps, action })
    }

    /// How fast one moves relative to the other on the way to a step by their places, where recorded speeds are far off
    /// around it.
    fn closing_by_places(&self, step: i64) -> Option<f64> {
        let around = (step - self.count(WHILE), step);
        let is_off = |drive: &Drive| drive.off(around).is_some();
        if !is_off(&self.ego) && !is_off(&self.other) {
            return None;
        }
        let between = |step| {
            let encounter = self.encounter(step)?;
            Some(encounter.other.pose.position - encounter.ego.pose.position)
        };
        let way = between(step)? - between(step - 1)?;
        Some(way.norm() / self.context.scene().scenario.dt())
    }

    /// That recorded speeds are not those of the places.
    fn speeds_off(&self) -> impl Iterator<Item = Fact> {
        let drives = [(Who::Other, &self.other), (Who::Ego, &self.ego)].into_iter();
        drives.filter_map(move |(who, drive)| {
            let by = drive.off(self.told_steps(drive))?;
            Some(Fact::SpeedsOff { who, by })
        })
    }

    /// How near they come.
    fn nearness(&self) -> Vec<Fact> {
        let contact = self.context.contacts(self.participant).first();
        let mut facts = contact.map_or_else(|| self.nearest(), |contact| self.touch(contact));
        facts.extend(self.speeds_off());
        facts
    }

    /// That they touch, and since when the time to collision was short.
    fn touch(&self, contact: &Contact) -> Vec<Fact> {
        let touched = self.time(contact.step);
        let ttc = self.lowest_ttc(&self.window.steps());
        let before = ttc.filter(|(step, _)| *step <= contact.step);
        let short = before.and_then(|(step, _)| self.short_since(step));
        // Where they touch it is short.
        let short = short.filter(|(since, _)| is_while(self.time(*since), touched));
        let contact = Fact::Contact {
            time: touched,
            closing_speed: contact.impact.closing_speed,
            by_places: self.closing_by_places(contact.step),
            is_possible: contact.is_possible,
        };
        let short = short.map(|(since, until)| self.short_ttc(since, until));
        short.into_iter().chain([contact]).collect()
    }

    /// The lowest time to collision and the smallest distance of those that do not touch.
    fn nearest(&self) -> Vec<Fact> {
        let other = self.context.participants()[self.participant].obstacle;
        let told = self.window.steps();
        let all = self.common.first().zip(self.common.last());
        let all = all.map_or(told.clone(), |(first, last)| *first..=*last);
        let mut facts: Vec<Fact> = Vec::new();
        let lowest = [self.lowest_ttc(&told), self.lowest_ttc(&all)];
        facts.extend(
            self.each_once(lowest, |step, seconds, is_outside| Fact::LowestTtc {
                time: self.time(step),
                seconds,
                is_outside,
                is_last: self.common.last() == Some(&step),
            }),
        );
        // A region does not go straight on.
        if facts.is_empty() && !other.is_set_based() {
            facts.push(Fact::NoCourse);
        }
        let distance = |step: i64| Some(self.encounter(step)?.distance());
        let nearest = [self.lowest(&told, distance), self.lowest(&all, distance)];
        facts.extend(self.each_once(nearest, |step, distance, is_outside| {
            let place = self.encounter(step).map(|e| e.relation().direction);
            Fact::Nearest {
                time: self.time(step),
                distance,
                place: place.unwrap_or(Direction::Contact),
                is_outside,
            }
        }));
        let participant = &self.context.participants()[self.participant];
        let scene = self.context.scene();
        let overlap = self
            .lowest(&all, distance)
            .and_then(|(step, _)| Contact::uncertain_overlap(scene, participant, step));
        facts.extend(overlap.map(|overlap| Fact::Uncertain { overlap }));
        facts
    }

    /// A lowest value of the time of the story, and that of the whole recording where it is lower.
    fn each_once(
        &self,
        [told, all]: [Option<(i64, f64)>; 2],
        fact: impl Fn(i64, f64, bool) -> Fact,
    ) -> Vec<Fact> {
        let all = all.filter(|(_, lowest)| told.is_none_or(|(_, told)| *lowest < told));
        let told = told.map(|(step, value)| fact(step, value, false));
        let all = all.map(|(step, value)| fact(step, value, true));
        told.into_iter().chain(all).collect()
    }

    /// What the ego does: where the time to collision gets short, whether it brakes then.
    fn ego(&self) -> Vec<Fact> {
        let lowest = self.lowest_ttc(&self.window.steps());
        let short = lowest.and_then(|(lowest, _)| self.short_since(lowest));
        let short = short.filter(|(since, until)| {
            self.window.steps().contains(since) && is_while(self.time(*since), self.time(*until))
        });
        let mut told = self.actions(&self.ego, self.late(short));
        let answer = short.and_then(|short| self.no_answer(&told, short));
        told.extend(answer);
        told.sort_by_key(|doing| doing.steps);
        if told.is_empty() {
            told.extend(self.keeps_on(&self.ego, (self.window.first(), self.window.last())));
        }
        let is_brake = |doing: &&Doing| matches!(doing.action, Action::Brake { .. });
        let is_one = told.iter().filter(is_brake).count() == 1;
        let mut facts = Vec::new();
        for doing in told {
            facts.push(self.does(Who::Ego, &doing));
            if is_one && is_brake(&&doing) {
                facts.extend(short.and_then(|short| self.reaction(doing.steps.0, short)));
            }
        }
        facts
    }

    /// That the ego moves and does not brake for what is not behind it while the time to collision is short, nor shortly
    /// before; or how it goes on where nothing of that time is told.
    fn no_answer(&self, told: &[Doing], (since, until): (i64, i64)) -> Option<Doing> {
        let is_long = until - since >= self.count(WHILE);
        let moves = self.ego.speeds((since, until)).1 >= STANDING;
        let place = self.encounter(since).map(|e| e.relation().direction);
        let is_behind = place.is_none_or(Direction::is_behind);
        let brakes = self.ego.doings.iter().any(|doing| {
            let (from, to) = doing.steps;
            let is_near = from <= until && to > since - self.count(SHORTLY);
            is_near && matches!(doing.action, Action::Brake { .. })
        });
        if is_long && moves && !is_behind && !brakes && self.ego.loss((since, until)) < NOTABLE {
            let (steps, action) = ((since, until), Action::NotBrake);
            return Some(Doing { steps, action });
        }
        let is_told = { told.iter() }.any(|doing| doing.steps.0 <= until && doing.steps.1 >= since);
        let keeps_on = || self.keeps_on(&self.ego, (since, until));
        (is_long && !is_told).then(keeps_on)?
    }

    /// When the time to collision got short, where the ego begins to brake at a step while it is.
    fn reaction(&self, step: i64, (since, until): (i64, i64)) -> Option<Fact> {
        // The recording tells when it got short, and the ego did not slow down before.
        self.encounter(since - 1)?;
        let is_reaction = is_while(self.time(since), self.time(step))
            && step <= until
            && step > self.window.first()
            && self.ego.loss((since, step)) < NOTABLE;
        is_reaction.then(|| self.short_ttc(since, until))
    }

    /// Who leaves first the place where both ways overlap.
    fn pass(&self) -> Option<Fact> {
        let passing = self.context.passing(self.participant)?;
        // Who comes there the same way follows.
        let step = |time: f64| (time / self.context.scene().scenario.dt()).round() as i64;
        let (first, second) = (step(passing.left), step(passing.entered));
        let at = |step| {
            Some((
                self.encounter(step)?.ego.pose,
                self.encounter(step)?.other.pose,
            ))
        };
        let ((ego, other), (ego_later, other_later)) = (at(first)?, at(second)?);
        let headings = if passing.ego_first {
            (ego.heading, other_later.heading)
        } else {
            (ego_later.heading, other.heading)
        };
        if angle_between(headings.0, headings.1).abs() < CROSSING {
            return None;
        }
        Some(Fact::Pass {
            first: if passing.ego_first {
                Who::Ego
            } else {
                Who::Other
            },
            left: passing.left,
            entered: passing.entered,
        })
    }

    fn ttc(&self, step: i64) -> Option<f64> {
        // Regions do not go straight on.
        let encounter = self.encounter(step).filter(|e| !e.is_with_occupancy())?;
        ttc_measure()?.evaluate(&encounter).value()
    }

    /// The step of some with the lowest time to collision, the first of several.
    fn lowest_ttc(&self, steps: &RangeInclusive<i64>) -> Option<(i64, f64)> {
        self.lowest(steps, |step| self.ttc(step))
    }

    fn lowest(
        &self,
        steps: &RangeInclusive<i64>,
        value: impl Fn(i64) -> Option<f64>,
    ) -> Option<(i64, f64)> {
        let readings = steps.clone().filter_map(|step| Some((step, value(step)?)));
        readings.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Since which step the time to collision is short until another one; nothing where it is not.
    fn short_since(&self, until: i64) -> Option<(i64, i64)> {
        let is_short = |step: &i64| self.ttc(*step).is_some_and(|seconds| seconds <= SHORT);
        let since = { (i64::MIN..=until).rev() }.take_while(is_short).last()?;
        Some((since, until))
    }

    fn short_ttc(&self, since: i64, until: i64) -> Fact {
        Fact::ShortTtc {
            time: self.time(since),
            until: self.time(until),
        }
    }
}

/// Whether times differ as they are told.
fn is_while(from: f64, to: f64) -> bool {
    to - from >= 0.1
}

fn ttc_measure() -> Option<&'static Measure> {
    measure("ttc")
}
