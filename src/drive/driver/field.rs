//! Everyone along the ego's own path around one event: worked out once for all drivers and all moments.

use std::sync::OnceLock;

use nearmiss_base::geometry::{Area, Footprint, Placed, Point, Pose, Vector, angle_between};
use nearmiss_scene::metrics::{DrivenPath, Encounter};
use nearmiss_scene::scenario::{Motion, Participant, Scene};

use super::competent::WANDERING;
use super::ideal::FARTHEST;
use super::model::{EXPECTATION, Seen, surprise};
use super::ride::{Spot, Touch};

/// An encounter of the ego with an obstacle: the stretch of the recording around it, along the ego's path.
#[derive(Debug)]
pub struct Field<'s> {
    pub(super) scene: &'s Scene,
    /// The other in it.
    pub(super) obstacle: i64,
    /// Its step: of the contact, or of a near miss its most severe one.
    pub(super) event: i64,
    /// The ego's own contact with the obstacle; `None` of a near miss.
    pub(super) contact: Option<Touch>,
    pub(super) lookout: Lookout,
    /// The ego, recorded: arc length (m) and speed (m/s) at each step from `first` on.
    pub(super) ego: Vec<(f64, f64)>,
    pub(super) first: i64,
    /// The last step that is looked at; those after the recording are continued with heading and speed kept.
    pub(super) last: i64,
    pub(super) others: Vec<Other<'s>>,
    /// The body of the ego.
    pub(super) body: Block,
    /// Whom a ride may touch on the way to each step from the first on.
    pub(super) near: Vec<Vec<Nearby>>,
    /// The lanelets around the path, and the same with small gaps closed, once they were asked for; `None` where the road is
    /// not known.
    pub(super) road: [OnceLock<Option<Area>>; 2],
}

/// Another road user that a ride may touch on the way to a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearby {
    /// Its place in [`Field::others`].
    pub other: usize,
    /// Where it is then: along the path and across, metres.
    along: f64,
    aside: f64,
    /// Between its middle and the ego's along the path and across, beside what the ego moves, at most, metres.
    long: f64,
    lat: f64,
    /// Its body on the way there, if that is the same all along and was there before.
    pub body: Option<MovingBlock>,
}

impl Nearby {
    /// Whether a body at a spot, which moved so far (m) along the path, can touch it.
    pub fn is_reached(&self, spot: &Spot, moved: f64) -> bool {
        (self.along - spot.s).abs() <= self.long + moved
            && (self.aside - spot.aside).abs() <= self.lat
    }
}

/// Bodies farther apart than this cannot touch within a step beyond what they move, metres.
const MARGIN: f64 = 1.0;

/// Another road user of a field.
#[derive(Debug)]
pub(super) struct Other<'s> {
    pub participant: Participant<'s>,
    /// Its body, if that is the same all along.
    pub body: Option<Block>,
    /// Its place at each step from the field's first on.
    pub places: Vec<Option<Place>>,
}

/// Where another road user is at a step. Metres, m/s, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Its pose.
    pub pose: Pose,
    /// Its velocity.
    pub velocity: Vector,
    /// The middle of its body, by arc length.
    pub along: f64,
    /// The middle of its body, to the left of the path.
    pub aside: f64,
    /// Half of its body along the path.
    pub half_long: f64,
    /// Half of its body across the path.
    pub half_lat: f64,
    /// Its speed along the path.
    pub speed: f64,
    /// Its speed to the left across the path.
    pub across: f64,
    /// Its heading from that of the path.
    pub turned: f64,
    /// Whether heading and speed are known at this step, and not only later.
    pub is_known: bool,
}

/// How long before an event a driver takes the wheel, seconds.
const BEFORE: f64 = 5.0;

/// How long after an event is looked at, seconds.
pub(super) const AFTER: f64 = 4.0;

/// Others are looked at within this of the box around the ego's path, metres.
const AROUND: f64 = 20.0;

/// The change of speed that a driver sees is that of this time, seconds: the risk evaluation time of UN Regulation 157.
const EVALUATION: f64 = 0.4;

/// Who is narrower hides nobody, metres: half of a width.
const HIDING: f64 = 0.7;

impl<'s> Field<'s> {
    /// The field around the ego's encounter with an obstacle that is worst at a step: from 5 s before it to 4 s after it, or
    /// until the ego touches another one, which is another encounter. `None` where the ego is not there before, touched
    /// another one before, or drives back over its own way into it.
    #[must_use]
    pub fn around(scene: &'s Scene, obstacle: i64, event: i64) -> Option<Self> {
        let dt = scene.scenario.dt();
        let steps = |seconds: f64| (seconds / dt).round() as i64;
        let recorded = scene.steps();
        let first = recorded.start.max(event - steps(BEFORE));
        let track = &scene.ego.track;
        let mut motions: Vec<(i64, Motion)> = Vec::new();
        let last = event + steps(AFTER);
        for step in first..recorded.end.min(last + 1) {
            match track.at(step) {
                Some(motion) => motions.push((step, *motion)),
                // Before a gap nothing leads to the event.
                None if step < event => motions.clear(),
                None => break,
            }
        }
        let first = motions.first()?.0;
        if first >= event {
            return None;
        }
        let path = DrivenPath::from_motions(motions.iter().copied());
        let ego = { motions.iter() }
            .map(|(step, motion)| Some((path.length_at(*step)?, motion.velocity.abs())));
        let ego: Vec<(f64, f64)> = ego.collect::<Option<_>>()?;
        let mut field = Self {
            scene,
            obstacle,
            event,
            contact: None,
            lookout: Lookout::new(path, scene.ego_footprint_at(event), dt),
            ego,
            first,
            last,
            others: Vec::new(),
            body: Block::around(&scene.ego.footprint),
            near: Vec::new(),
            road: Default::default(),
        };
        field.others = field.look_around();
        field.near = field.find_near();
        let own = field.recorded();
        if let Some(touch) = own.touch {
            field.contact = field.last_touch_with(obstacle, &own);
            match field.contact {
                Some(_) => {}
                None if touch.step <= event => return None,
                None => field.last = touch.step - 1,
            }
        }
        let is_there = |one: &Participant<'_>| one.obstacle.id == obstacle;
        let other = scene.participants().find(is_there)?;
        let touches = Encounter::at(scene, &other, event).is_some_and(|it| it.contact().is_some());
        // Who drives back over its own way meets others at a place that the way has twice.
        (field.contact.is_some() || !touches).then_some(field)
    }

    fn look_around(&self) -> Vec<Other<'s>> {
        let end = self.ego.last().map(|(s, v)| s + v * AFTER);
        let places = self.ego.iter().map(|(s, _)| *s).chain(end);
        let Some(from) = self.lookout.path.at(0.0) else {
            return Vec::new();
        };
        // In the frame of the path's beginning: how the map lies must not decide who is looked at.
        let local = |p: &Point| from.to_local(p);
        let points = places.filter_map(|s| self.lookout.path.at(s));
        let bounds = points.fold(None, |bounds: Option<(Point, Point)>, pose| {
            let p = local(&pose.position);
            Some(bounds.map_or((p, p), |(low, high)| (low.inf(&p), high.sup(&p))))
        });
        let Some((low, high)) = bounds else {
            return Vec::new();
        };
        let near = |p: &Point, reach: f64| {
            let (most, p) = (AROUND + reach, local(p));
            (low.x - most..=high.x + most).contains(&p.x)
                && (low.y - most..=high.y + most).contains(&p.y)
        };
        let ends = self.recording_ends();
        let participants = self.scene.participants().filter_map(|participant| {
            // Of a region that someone may be in nothing is known.
            if participant.obstacle.is_set_based() {
                return None;
            }
            let mut hint = None;
            let mut place = |step: i64| {
                let (motion, is_known) = self.motion(&participant, step, ends)?;
                let footprint = participant.footprint_at(step);
                near(&motion.pose.position, footprint.reach()).then_some(())?;
                self.lookout.place(footprint, &motion, is_known, &mut hint)
            };
            let places: Vec<Option<Place>> = (self.first..=self.last).map(&mut place).collect();
            let is_there = places.iter().any(Option::is_some);
            let body = participant.footprint_at(self.first);
            let is_rigid = (self.first..=self.last)
                .all(|step| std::ptr::eq(participant.footprint_at(step), body));
            is_there.then(|| Other {
                participant,
                body: is_rigid.then(|| Block::around(body)),
                places,
            })
        });
        participants.collect()
    }

    /// Whom a ride may touch on the way to each step.
    fn find_near(&self) -> Vec<Vec<Nearby>> {
        let [(rear, front), (right, left)] = self.lookout.own;
        let own = (front - rear).hypot(left - right) / 2.0 + front.abs().max(rear.abs());
        let nearby = |i: usize, at: usize| {
            let other = &self.others[i];
            let place = other.places[at].as_ref()?;
            let around = own + place.velocity.norm() * self.lookout.dt + MARGIN;
            let lat = around + place.half_lat;
            let before = at.checked_sub(1).and_then(|at| other.places[at].as_ref());
            { place.aside.abs() <= lat + FARTHEST }.then(|| Nearby {
                other: i,
                along: place.along,
                aside: place.aside,
                long: around + place.half_long,
                lat,
                body: { other.body.as_ref().zip(before) }
                    .map(|(body, before)| body.between(&before.pose, &place.pose)),
            })
        };
        let at = |at: usize| {
            { 0..self.others.len() }
                .filter_map(|i| nearby(i, at))
                .collect()
        };
        (0..=(self.last - self.first) as usize).map(at).collect()
    }

    /// The motion of another at a step, continued after the `end` of the recording, and whether it is known then.
    fn motion(&self, participant: &Participant<'_>, step: i64, end: i64) -> Option<(Motion, bool)> {
        let track = participant.obstacle.track();
        if let Some(motion) = participant.at(step) {
            return Some((*motion, track.motion_known_at(step) <= step));
        }
        // Who was gone before the recording ended stays away.
        let motion = participant.at(end).filter(|_| step > end)?;
        let away = motion.velocity_vector() * (step - end) as f64 * self.lookout.dt;
        let pose = Pose {
            position: motion.pose.position + away,
            ..motion.pose
        };
        Some((Motion { pose, ..*motion }, true))
    }

    /// The last step of the recording: of the ego, or of the traffic where that goes on.
    fn recording_ends(&self) -> i64 {
        let tracks = self
            .scene
            .participants()
            .map(|p| p.obstacle.track().steps().end - 1);
        tracks.max().unwrap_or(i64::MIN).max(self.scene.last_step())
    }

    /// The ego's body at an arc length and an offset to the left, metres, turned by so much from the path.
    pub(super) fn own_at(&self, spot: &Spot) -> Option<Placed<'_>> {
        Some(self.scene.ego.footprint.at(self.pose(spot)?))
    }

    /// The ego's pose at a spot.
    pub(super) fn pose(&self, spot: &Spot) -> Option<Pose> {
        let mut pose = self.lookout.path.at(spot.s)?;
        pose.position += pose.left() * spot.aside;
        pose.heading += spot.turned;
        Some(pose)
    }

    /// What a driver at an arc length (m) sees at a step, into `seen`.
    pub(super) fn see(&self, step: i64, s: f64, seen: &mut Vec<Seen>) {
        let at = (step - self.first) as usize;
        let [before, expected] = [EVALUATION, EXPECTATION].map(|ago| self.lookout.steps(ago));
        let others = self.others.iter().map(|other| {
            let then = |ago: usize| other.places[at.checked_sub(ago)?];
            [other.places[at], then(before), then(expected)]
        });
        self.lookout.see(s, others, seen);
    }
}

/// The box around a body in its own frame, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// From the place of the body along its heading and to the left.
    middle: Vector,
    half: Vector,
    /// Of its farthest point from the place of the body.
    reach: f64,
}

/// A box on its way from one pose to another.
#[derive(Debug, Clone, Copy)]
pub(super) struct MovingBlock {
    ends: [End; 2],
    half: Vector,
    /// How far its points are off straight lines at most, metres.
    bent: f64,
    reach: f64,
}

#[derive(Debug, Clone, Copy)]
struct End {
    place: Point,
    middle: Point,
    axes: [Vector; 2],
}

impl Block {
    /// That of a body.
    pub fn around(body: &Footprint) -> Self {
        let [(rear, front), (right, left)] = extents(body);
        Self {
            middle: Vector::new(f64::midpoint(rear, front), f64::midpoint(right, left)),
            half: Vector::new((front - rear) / 2.0, (left - right) / 2.0),
            reach: body.reach(),
        }
    }

    /// How far a point of it is from the place of the body at most, metres.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The same on its way.
    pub fn between(&self, from: &Pose, to: &Pose) -> MovingBlock {
        let ends = [from, to].map(|pose| {
            let (sin, cos) = pose.heading.sin_cos();
            let axes = [Vector::new(cos, sin), Vector::new(-sin, cos)];
            End {
                place: pose.position,
                middle: pose.position + axes[0] * self.middle.x + axes[1] * self.middle.y,
                axes,
            }
        });
        MovingBlock {
            ends,
            half: self.half,
            bent: angle_between(from.heading, to.heading).abs() * self.reach,
            reach: self.reach,
        }
    }
}

impl MovingBlock {
    /// Whether two stay apart for sure: discs around both never meet, or one line separates them at both ends, by more than
    /// their turning takes.
    pub fn is_apart(&self, other: &Self) -> bool {
        let between = [0, 1].map(|end| other.ends[end].place - self.ends[end].place);
        let moved = between[1] - between[0];
        let length = moved.norm_squared();
        let share = if length > 0.0 {
            (-between[0].dot(&moved) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let reach = self.reach + other.reach + LEAST;
        if (between[0] + moved * share).norm_squared() > reach * reach {
            return true;
        }
        let least = self.bent + other.bent + LEAST;
        let middles = [0, 1].map(|end| other.ends[end].middle - self.ends[end].middle);
        let axes = self.ends[1].axes.iter().chain(&other.ends[1].axes);
        { axes }.any(|axis| {
            let gap = |end: usize| {
                let between = middles[end].dot(axis);
                let reach = self.along(end, axis) + other.along(end, axis);
                (between > 0.0, between.abs() - reach)
            };
            let (from, to) = (gap(0), gap(1));
            from.0 == to.0 && from.1 > least && to.1 > least
        })
    }

    /// How far it reaches from its middle along an axis.
    fn along(&self, end: usize, axis: &Vector) -> f64 {
        let [forward, left] = self.ends[end].axes;
        self.half.x * forward.dot(axis).abs() + self.half.y * left.dot(axis).abs()
    }
}

/// A gap below this is none, metres.
const LEAST: f64 = 1e-3;

/// How far a body reaches along its heading, and across it to the left, metres.
fn extents(body: &Footprint) -> [(f64, f64); 2] {
    let flat = Pose::new(0.0, 0.0, 0.0);
    let axis = |x, y| body.at(flat).extent(&flat.position, &Vector::new(x, y));
    [axis(1.0, 0.0), axis(0.0, 1.0)]
}

/// What the driver of a body on a path sees of others.
#[derive(Debug)]
pub(crate) struct Lookout {
    pub path: DrivenPath,
    /// The ego's body along its heading, from its centre: rear and front, right and left, metres.
    pub own: [(f64, f64); 2],
    /// Seconds between two steps.
    pub dt: f64,
}

impl Lookout {
    /// The lookout of a body.
    pub fn new(path: DrivenPath, body: &Footprint, dt: f64) -> Self {
        Self {
            path,
            own: extents(body),
            dt,
        }
    }

    /// Steps in a time, at least one.
    pub fn steps(&self, seconds: f64) -> usize {
        ((seconds / self.dt).round() as usize).max(1)
    }

    /// Where others are now, were before and were when they were last expected to be somewhere.
    pub const LOOKS: [f64; 3] = [0.0, EVALUATION, EXPECTATION];

    /// A body on the path; the place is looked for near the piece `hint`, or everywhere.
    pub fn place(
        &self,
        footprint: &Footprint,
        motion: &Motion,
        is_known: bool,
        hint: &mut Option<usize>,
    ) -> Option<Place> {
        let position = motion.pose.position;
        let (s, _) = self.path.project_near(&position, hint)?;
        let there = self.path.at(s)?;
        let (forward, left) = (there.forward(), there.left());
        let body = footprint.at(motion.pose);
        let (rear, front) = body.extent(&there.position, &forward);
        let (right, left_end) = body.extent(&there.position, &left);
        let velocity = motion.velocity_vector();
        Some(Place {
            pose: motion.pose,
            velocity,
            along: s + f64::midpoint(rear, front),
            aside: f64::midpoint(right, left_end),
            half_long: (front - rear) / 2.0,
            half_lat: (left_end - right) / 2.0,
            speed: velocity.dot(&forward),
            across: velocity.dot(&left),
            turned: angle_between(there.heading, motion.pose.heading),
            is_known,
        })
    }

    /// What is seen from an arc length (m), into `seen`: of each where it is, and was at [`Self::LOOKS`].
    pub fn see(
        &self,
        s: f64,
        others: impl Iterator<Item = [Option<Place>; 3]>,
        seen: &mut Vec<Seen>,
    ) {
        seen.clear();
        let [(rear, front), (right, left)] = self.own;
        let (own_long, own_lat) = ((front - rear) / 2.0, (left - right) / 2.0);
        let (shift, side) = (f64::midpoint(rear, front), f64::midpoint(right, left));
        let passed = |ago: f64| self.steps(ago) as f64 * self.dt;
        let mut hides: Option<(f64, f64)> = None;
        for places in others {
            let [now, before, expected] = places.map(|place| place.filter(|place| place.is_known));
            let Some(now) = now else {
                continue;
            };
            let (ahead, aside) = (now.along - s - shift, now.aside - side);
            seen.push(Seen {
                ahead,
                gap_long: ahead.abs() - own_long - now.half_long,
                gap_lat: aside.abs() - own_lat - now.half_lat,
                aside,
                half_lengths: own_long + now.half_long,
                speed: now.speed,
                towards: -now.across * aside.signum(),
                acceleration: before
                    .map_or(0.0, |then| (now.speed - then.speed) / passed(EVALUATION)),
                left_lane: None,
                surprise: expected.map_or(0.0, |then| {
                    let seconds = passed(EXPECTATION);
                    let (along, aside) = (then.speed * seconds, then.across * seconds);
                    surprise(
                        now.along - then.along - along,
                        now.aside - then.aside - aside,
                    )
                }),
            });
            // A vehicle in the middle of the way hides what is in front of it.
            let in_front = ahead > 0.0 && aside.abs() <= WANDERING && now.half_lat > HIDING;
            if in_front && hides.is_none_or(|(nearest, _)| ahead < nearest) {
                hides = Some((ahead, now.half_lat));
            }
        }
        if let Some((nearest, half)) = hides {
            let hidden = |o: &Seen| {
                let half_lat = o.aside.abs() - o.gap_lat - own_lat;
                o.ahead > nearest && o.aside.abs() + half_lat <= half + WANDERING
            };
            seen.retain(|other| !hidden(other));
        }
    }
}
