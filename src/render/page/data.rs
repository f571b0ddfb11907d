//! What a page plays, as compact numbers: the map once, poses and measures per step.
//!
//! Lengths are whole centimetres from the page's origin, angles thousandths of a radian, speeds cm/s. Lists of them hold
//! the first number and then differences. Ids are texts: as numbers a browser would round those above 2^53.

use std::ops::RangeInclusive;

use nearmiss_base::geometry::{Footprint, Point, Pose};
use nearmiss_scene::metrics::{Danger, NoValue, Reading, SEVERITY_NAMES, Series};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Prediction, Track};
use serde::Serialize;

use crate::display::Area;
use crate::figure::Figure;
use crate::scene::{
    GoalArea, MapRequest, Paint, STRIPE, Surface, SurfaceKind, TrailSpan, Viewport, has_front,
    offset,
};
use crate::view::{MapExtent, Variations, View};

/// Points of a line or a ring, one coordinate after the other.
type Line = Vec<i64>;

/// The id of an obstacle.
type PageId = String;

/// Everything.
#[derive(Serialize)]
pub struct PageData<'a> {
    dt: f64,
    /// The first and the last step.
    steps: (i64, i64),
    view: PageView,
    /// Moments worth a look, the most severe first.
    moments: Vec<Moment>,
    map: PageMap,
    bodies: Vec<Body>,
    measures: Vec<PageMeasure<'a>>,
    /// Why there is no value, by the letters of [`Readings`].
    reasons: Vec<&'static str>,
    /// Of each obstacle that is measured, each measure over all steps.
    readings: Vec<(PageId, Vec<Readings>)>,
    /// Step, obstacle and place of each contact.
    contacts: Vec<(i64, PageId, i64, i64)>,
    lines: Vec<PageLine>,
}

/// What is seen at first.
#[derive(Serialize)]
struct PageView {
    /// The middle.
    at: (i64, i64),
    /// Metres from left to right.
    width: f64,
    /// The direction that is up, radians.
    up: f64,
    /// Whether the ego stays in the middle.
    follows: bool,
    /// Whether the ego drives upwards.
    turns: bool,
    /// The step, and the obstacle that is picked.
    step: i64,
    picked: Option<PageId>,
}

#[derive(Serialize)]
struct Moment {
    obstacle: PageId,
    step: i64,
    severity: &'static str,
    words: String,
}

/// From which step on a light has which colour.
type Change = (i64, &'static str);

#[derive(Serialize)]
struct PageMap {
    /// What each is for, and its ring.
    surfaces: Vec<(char, Line)>,
    /// Paint, width in widths of a painted line, and the line.
    borders: Vec<(char, f64, Line)>,
    /// Whether it is dashed, and the line.
    stops: Vec<(bool, Line)>,
    stripes: Vec<Line>,
    goals: Vec<Line>,
    regions: Vec<Line>,
    /// Place, and from which step on it has which colour.
    lights: Vec<(i64, i64, Vec<Change>)>,
    /// Obstacle, first and last step of its occupancy sets, and their rings.
    occupancies: Vec<(PageId, i64, i64, Vec<Line>)>,
}

/// A body, and where it is.
#[derive(Serialize)]
struct Body {
    /// `None` of the ego.
    id: Option<PageId>,
    kind: &'static str,
    stands: bool,
    has_front: bool,
    /// From its place on in the lists below, the rings in its own frame.
    shapes: Vec<(usize, Vec<Line>)>,
    /// First steps and lengths of the stretches in which it is there; none where it always is.
    runs: Vec<(i64, usize)>,
    x: Line,
    y: Line,
    heading: Line,
    speed: Line,
    acceleration: Line,
}

#[derive(Serialize)]
struct PageMeasure<'a> {
    id: &'static str,
    name: &'static str,
    axis: String,
    unit: &'static str,
    extreme: &'static str,
    /// Whether high values are dangerous; `None` where neither is.
    high: Option<bool>,
    levels: bool,
    thresholds: Vec<(&'a str, f64, bool)>,
}

/// Values in turn; for steps without one, the letter of the reason and how many they are.
type Readings = Vec<PageReading>;

#[derive(Serialize)]
#[serde(untagged)]
enum PageReading {
    Value(f64),
    None(String),
}

/// A line over the map.
#[derive(Serialize)]
struct PageLine {
    owner: LineOwner,
    dashed: bool,
    opacity: f64,
    line: Line,
}

#[derive(Serialize)]
#[serde(rename_all = "lowercase")]
enum LineOwner {
    Ego,
    Recorded,
    Other,
    Obstacle(PageId),
}

/// No number of a page is larger, so that none is lost in a browser.
const LARGEST: f64 = 1e13;

fn whole(value: f64, parts: f64) -> i64 {
    (value * parts).round().clamp(-LARGEST, LARGEST) as i64
}

/// The first number, and then differences.
fn differences(values: impl Iterator<Item = i64>) -> Line {
    let mut last = 0;
    let step = |value: i64| value - std::mem::replace(&mut last, value);
    values.map(step).collect()
}

/// Where the page's coordinates begin.
struct Origin(Point);

impl Origin {
    fn spot(&self, p: &Point) -> (i64, i64) {
        let d = p - self.0;
        (whole(d.x, 100.0), whole(d.y, 100.0))
    }

    fn line<'p>(&self, points: impl IntoIterator<Item = &'p Point>) -> Line {
        let (mut x, mut y) = (0, 0);
        let mut line = Vec::new();
        for p in points {
            let (to_x, to_y) = self.spot(p);
            line.extend([to_x - x, to_y - y]);
            (x, y) = (to_x, to_y);
        }
        line
    }

    fn lines(&self, rings: &[Vec<Point>]) -> Vec<Line> {
        rings.iter().map(|ring| self.line(ring)).collect()
    }
}

impl<'a> PageData<'a> {
    /// What a figure shows, at every step; the page opens at one of them.
    pub fn new(figure: &'a Figure<'a>, step: i64) -> Self {
        let subject = figure.subject();
        let steps = subject.steps();
        let view = figure.page_view(step);
        let origin = Origin(Point::new(
            view.frame.position.x.round(),
            view.frame.position.y.round(),
        ));
        let all = steps.start..=(steps.end - 1).max(steps.start);
        let mut bodies: Vec<Body> = subject
            .others()
            .filter_map(|obstacle| Body::of_obstacle(obstacle, &origin, &all))
            .collect();
        if let Some(scene) = subject.scene {
            let footprint = |step| Some(scene.ego_footprint_at(step));
            let mut ego = Body::new(&scene.ego.track, &footprint, &origin, &all);
            ego.kind = "ego";
            bodies.push(ego);
        }
        let moments = figure.moments().iter().map(|moment| Moment {
            obstacle: moment.obstacle.to_string(),
            step: moment.step,
            severity: SEVERITY_NAMES[usize::from(moment.grade.number())],
            words: moment.hazard.to_string(),
        });
        let mut reasons = Vec::new();
        Self {
            dt: subject.scenario.dt(),
            steps: (*all.start(), *all.end()),
            view: PageView::new(figure, &view, &origin, step),
            moments: moments.collect(),
            map: PageMap::new(figure, &origin, &all),
            bodies,
            measures: figure.page_measures(),
            readings: figure.page_readings(&mut reasons),
            reasons: reasons.into_iter().map(NoValue::reason).collect(),
            contacts: figure.page_contacts(&origin),
            lines: figure.page_lines(&origin),
        }
    }
}

impl PageView {
    fn new(figure: &Figure<'_>, view: &View, origin: &Origin, step: i64) -> Self {
        Self {
            at: origin.spot(&view.frame.position),
            width: (view.width() * 10.0).round() / 10.0,
            up: view.frame.heading,
            follows: figure.subject().scene.is_some()
                && matches!(figure.extent(MAP), MapExtent::Ego { .. }),
            turns: figure.look().ego_up,
            step,
            picked: figure.obstacles().first().map(i64::to_string),
        }
    }
}

impl PageMap {
    fn new(figure: &Figure<'_>, origin: &Origin, steps: &RangeInclusive<i64>) -> Self {
        let (basemap, subject) = (figure.basemap(), figure.subject());
        let is_crossing = |s: &&Surface| s.kind == SurfaceKind::Crossing;
        let surfaces = basemap.surfaces.iter();
        let areas = { basemap.areas.iter() }.map(|area| ('a', origin.line(&area.ring)));
        let lanes = { surfaces.clone() }.map(|s| (surface(s.kind), origin.line(&s.ring)));
        let borders = basemap.borders.iter().flat_map(|border| {
            border.lines.iter().map(|line| {
                let points = match line.offset {
                    0.0 => origin.line(&border.points),
                    aside => origin.line(&offset(&border.points, aside * LINE)),
                };
                (paint(line.paint), line.width, points)
            })
        });
        let goal = |goal: &GoalArea| match goal {
            GoalArea::Lanelet(place) => vec![origin.line(&basemap.surfaces[*place].ring)],
            GoalArea::Region(rings) => origin.lines(rings),
            GoalArea::Point(at) => vec![origin.line(&square(at))],
        };
        let lights = subject.scenario.network.lights.iter();
        let lights = lights.zip(basemap.places_of_lights());
        let obstacles = &subject.scenario.obstacles;
        let standing = obstacles
            .iter()
            .filter(|obstacle| obstacle.role == ObstacleRole::Environment)
            .filter_map(|obstacle| Some(obstacle.footprint.as_ref()?.shape().outlines()));
        let mut occupancies = Vec::new();
        for obstacle in obstacles {
            if let Prediction::Occupancies(all) = &obstacle.prediction {
                occupancies.extend(all.iter().map(|one| {
                    let rings = origin.lines(&one.region.outlines());
                    (obstacle.id.to_string(), one.time.from, one.time.to, rings)
                }));
            }
        }
        Self {
            surfaces: areas.chain(lanes).collect(),
            stripes: surfaces
                .filter(is_crossing)
                .flat_map(|surface| surface.stripes(STRIPE))
                .map(|ring| origin.line(&ring))
                .collect(),
            borders: borders.collect(),
            stops: (basemap.stop_lines.iter())
                .map(|line| (line.dashed, origin.line(&line.ends)))
                .collect(),
            goals: basemap.goals.iter().flat_map(goal).collect(),
            regions: standing.flat_map(|rings| origin.lines(&rings)).collect(),
            lights: lights
                .filter_map(|(light, at)| {
                    let (x, y) = origin.spot(&at?);
                    let colors = steps
                        .clone()
                        .map(|step| (step, light.color_at(step).name()));
                    let mut changes: Vec<(i64, &str)> = colors.collect();
                    changes.dedup_by_key(|(_, color)| *color);
                    Some((x, y, changes))
                })
                .collect(),
            occupancies,
        }
    }
}

/// Width of a painted line, metres.
const LINE: f64 = 0.15;

/// Half of the side of the square that marks a point to reach, metres.
const GOAL: f64 = 1.0;

fn square(at: &Point) -> [Point; 4] {
    [(-GOAL, -GOAL), (GOAL, -GOAL), (GOAL, GOAL), (-GOAL, GOAL)]
        .map(|(x, y)| Point::new(at.x + x, at.y + y))
}

fn surface(kind: SurfaceKind) -> char {
    match kind {
        SurfaceKind::Crossing => 'c',
        SurfaceKind::Sidewalk | SurfaceKind::Bicycle => 'p',
        _ => 'r',
    }
}

fn paint(paint: Paint) -> char {
    match paint {
        Paint::Solid | Paint::Curb => 's',
        Paint::LoweredCurb => 'l',
        Paint::Dashed => 'd',
        Paint::None => 'n',
        Paint::Unknown => 'u',
    }
}

impl Body {
    fn of_obstacle(
        obstacle: &Obstacle,
        origin: &Origin,
        steps: &RangeInclusive<i64>,
    ) -> Option<Self> {
        // What stands beside the road is a region of the map; occupancy sets are regions, too.
        if !matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic)
            || obstacle.is_set_based()
        {
            return None;
        }
        let footprint = |step| obstacle.footprint_at(step);
        let stands = obstacle.role == ObstacleRole::Static;
        let first = obstacle.track().steps().start;
        let once = first..=first;
        let steps = if stands { &once } else { steps };
        let mut body = Self::new(obstacle.track(), &footprint, origin, steps);
        if stands {
            body.runs.clear();
        }
        (!body.x.is_empty()).then_some(Self {
            id: Some(obstacle.id.to_string()),
            kind: obstacle.kind.name(),
            stands,
            has_front: has_front(obstacle.kind),
            ..body
        })
    }

    fn new<'f>(
        track: &Track,
        footprint: &dyn Fn(i64) -> Option<&'f Footprint>,
        origin: &Origin,
        steps: &RangeInclusive<i64>,
    ) -> Self {
        let motions: &[(i64, Motion)] = track.during(steps);
        let mut runs: Vec<(i64, usize)> = Vec::new();
        let mut shapes: Vec<(usize, Vec<Line>)> = Vec::new();
        let own = Origin(Point::origin());
        for (place, (step, _)) in motions.iter().enumerate() {
            match runs.last_mut() {
                Some((from, count)) if *from + *count as i64 == *step => *count += 1,
                _ => runs.push((*step, 1)),
            }
            let rings = footprint(*step).map(|body| own.lines(&body.shape().outlines()));
            if let Some(rings) = rings
                && shapes.last().is_none_or(|(_, known)| *known != rings)
            {
                shapes.push((place, rings));
            }
        }
        let each = |value: fn(&Motion) -> f64, parts: f64| {
            differences(
                motions
                    .iter()
                    .map(|(_, motion)| whole(value(motion), parts)),
            )
        };
        let places: Vec<(i64, i64)> = motions
            .iter()
            .map(|(_, motion)| origin.spot(&motion.pose.position))
            .collect();
        Self {
            id: None,
            kind: "",
            stands: false,
            has_front: true,
            shapes,
            runs,
            x: differences(places.iter().map(|place| place.0)),
            y: differences(places.iter().map(|place| place.1)),
            heading: each(|m| m.pose.heading, 1000.0),
            speed: each(|m| m.velocity, 100.0),
            acceleration: each(|m| m.acceleration, 100.0),
        }
    }
}

/// The page is laid out for a map of this size; browsers fit it to theirs.
const MAP: Area = Area {
    x: 0.0,
    y: 0.0,
    width: 800.0,
    height: 520.0,
};

impl<'a> Figure<'a> {
    /// What is seen at first.
    fn page_view(&self, step: i64) -> View {
        let ego_up = self.look().ego_up;
        View::new(self.extent(MAP), ego_up, &self.subject(), step, MAP)
    }

    fn page_measures(&'a self) -> Vec<PageMeasure<'a>> {
        let measures = self.series().map_or(&[][..], |series| series.measures());
        let each = measures.iter().map(|measure| PageMeasure {
            id: measure.id,
            name: measure.name,
            axis: measure.axis_name(measure.name),
            unit: measure.unit,
            extreme: measure.extreme(),
            high: match measure.danger {
                Danger::Low => Some(false),
                Danger::High => Some(true),
                Danger::Neutral => None,
            },
            levels: measure.is_ordinal(),
            thresholds: self
                .thresholds()
                .for_measure(measure.id)
                .map(|t| (t.name.as_str(), t.value, t.strict))
                .collect(),
        });
        each.collect()
    }

    /// The values; why there is none is a place in `reasons`.
    fn page_readings(&self, reasons: &mut Vec<NoValue>) -> Vec<(PageId, Vec<Readings>)> {
        let Some(series) = self.series() else {
            return Vec::new();
        };
        let mut all = Vec::new();
        for id in series.obstacles() {
            let measures = series.measures().iter();
            let rows = measures.map(|measure| readings(series.row(measure.id, *id), reasons));
            all.push((id.to_string(), rows.collect()));
        }
        all
    }

    fn page_contacts(&self, origin: &Origin) -> Vec<(i64, PageId, i64, i64)> {
        let touches = |series: &&Series| {
            let mut obstacles = series.obstacles().iter();
            obstacles.any(|id| series.contact(*id).is_some())
        };
        if self.series().filter(touches).is_none() {
            return Vec::new();
        }
        let mut found = Vec::new();
        for step in self.steps() {
            let nowhere = Viewport::new(Pose::new(0.0, 0.0, 0.0), (0.0, 0.0));
            let request = MapRequest {
                subject: self.subject(),
                basemap: self.basemap(),
                step,
                viewport: nowhere,
                highlighted: &[],
                series: None,
                variations: Variations::default(),
                trails: [TrailSpan::WHOLE; 2],
            };
            found.extend(request.contacts().into_iter().map(|contact| {
                let (x, y) = origin.spot(&contact.at);
                (step, contact.obstacle.to_string(), x, y)
            }));
        }
        found
    }

    /// Recorded motions of a variant's attackers, and the lines that the user adds.
    fn page_lines(&self, origin: &Origin) -> Vec<PageLine> {
        let recorded = self.variations().iter().map(|both| {
            let after = both.recorded.track().during(&(both.from..=i64::MAX));
            PageLine {
                owner: LineOwner::Recorded,
                dashed: true,
                opacity: 1.0,
                line: origin.line(after.iter().map(|(_, motion)| &motion.pose.position)),
            }
        });
        let added = self.forecasts().iter().map(|forecast| PageLine {
            owner: match forecast.id {
                Some(id) if self.is_ego(id) => LineOwner::Ego,
                Some(id) => LineOwner::Obstacle(id.to_string()),
                None => LineOwner::Other,
            },
            dashed: false,
            opacity: forecast.opacity(),
            line: origin.line(&forecast.points),
        });
        recorded.chain(added).collect()
    }
}

/// Values with as many digits as matter; of a gap of centimetres, the millimetres do.
fn readings(row: &[Reading], reasons: &mut Vec<NoValue>) -> Readings {
    let mut found = Vec::new();
    for same in row.chunk_by(|a, b| a.value().is_none() && a == b) {
        let Some(Reading::None(why)) = same.first().filter(|r| r.value().is_none()) else {
            let values = same.iter().filter_map(|reading| reading.value());
            found.extend(values.map(|v| PageReading::Value(rounded(v))));
            continue;
        };
        let known = reasons.iter().position(|reason| reason == why);
        let place = known.unwrap_or_else(|| {
            reasons.push(*why);
            reasons.len() - 1
        });
        let letter = u8::try_from(place).map_or('z', |place| char::from(b'a' + place.min(25)));
        found.push(PageReading::None(format!("{letter}{}", same.len())));
    }
    found
}

fn rounded(value: f64) -> f64 {
    let parts = if value.abs() < 1.0 { 1000.0 } else { 100.0 };
    (value * parts).round() / parts
}
