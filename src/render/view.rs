//! From the world to the page: which part of the map is seen, which way up, how large.

use std::fmt;

use super::display::{Area, Spot};
use super::scene::Viewport;
use nearmiss_base::geometry::{Bounds, Point, Pose};
use nearmiss_scene::scenario::{Obstacle, Scenario, Scene};

/// Which part of the map is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MapExtent {
    /// Around the ego, 60 m wide; figures are wider where an obstacle that is pointed out needs it at the moment that
    /// matters. Without an ego, everything.
    Usual,
    /// Around the ego, so many metres wide; without an ego, everything.
    Ego {
        /// Metres from left to right.
        width: f64,
    },
    /// Everyone who moves, and the road around them.
    All,
    /// Around a point.
    Around {
        /// The middle.
        center: Point,
        /// Metres from left to right.
        width: f64,
    },
}

impl fmt::Display for MapExtent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usual => f.write_str("ego"),
            Self::Ego { width } => write!(f, "ego,{width}"),
            Self::All => f.write_str("all"),
            Self::Around { center, width } => write!(f, "{},{},{width}", center.x, center.y),
        }
    }
}

impl MapExtent {
    /// `ego`, `ego,WIDTH`, `all` or `X,Y,WIDTH`, in metres.
    ///
    /// # Errors
    /// It is none of them: in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "unknown view `{text}`; write ego, ego,WIDTH, all or X,Y,WIDTH, in metres, with WIDTH from \
                 {MIN_WIDTH} to {MAX_WIDTH}"
            )
        };
        let numbers = |words: &[&str]| {
            let each = words.iter().map(|w| w.trim().parse::<f64>().ok());
            let all: Option<Vec<f64>> = each.collect();
            all.filter(|all| all.iter().all(|n| n.is_finite()))
        };
        let words: Vec<&str> = text.split(',').collect();
        let seen = match &words[..] {
            ["all"] => Some(Self::All),
            ["ego"] => Some(Self::Usual),
            ["ego", width] => numbers(&[width]).map(|n| Self::Ego { width: n[0] }),
            rest if rest.len() == 3 => numbers(rest).map(|n| Self::Around {
                center: Point::new(n[0], n[1]),
                width: n[2],
            }),
            _ => None,
        };
        let fits = |seen: &Self| match seen {
            Self::Ego { width } | Self::Around { width, .. } => {
                (MIN_WIDTH..=MAX_WIDTH).contains(width)
            }
            Self::Usual | Self::All => true,
        };
        seen.filter(fits).ok_or_else(wrong)
    }
}

/// Metres around the ego that are seen unless something else is asked for or pointed out.
const USUAL_WIDTH: f64 = 60.0;

/// Metres that a picture is wide at least and at most.
const MIN_WIDTH: f64 = 2.0;
const MAX_WIDTH: f64 = 100_000.0;

/// How the world lies on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// What is in the middle, and the direction that is up.
    pub frame: Pose,
    /// Points a metre, in both directions the same.
    pub scale: f64,
    /// Where on the page.
    pub area: Area,
}

impl View {
    /// The view of a scenario at a step.
    #[must_use]
    pub fn new(
        seen: MapExtent,
        ego_up: bool,
        subject: &Subject<'_>,
        step: i64,
        area: Area,
    ) -> Self {
        let up = subject.up(ego_up, step);
        Self::turned(seen, up, subject, step, area)
    }

    /// The same with a direction that is up, radians.
    pub(super) fn turned(
        seen: MapExtent,
        up: f64,
        subject: &Subject<'_>,
        step: i64,
        area: Area,
    ) -> Self {
        let ego = subject.scene.and_then(|scene| scene.ego.track.at(step));
        let around = |center: Point, width: f64| Self {
            frame: Pose {
                position: center,
                heading: up,
            },
            scale: area.width / width,
            area,
        };
        match (seen, ego) {
            (MapExtent::Around { center, width }, _) => around(center, width),
            (MapExtent::Ego { width }, Some(motion)) => around(motion.pose.position, width),
            (MapExtent::Usual, Some(motion)) => around(motion.pose.position, USUAL_WIDTH),
            _ => {
                let turned = Pose {
                    position: Point::origin(),
                    heading: up,
                };
                let spots = subject.everywhere();
                let local: Vec<Point> = spots.iter().map(|p| turned.to_local(p)).collect();
                let Some(bounds) = Bounds::from_points(&local) else {
                    return around(Point::origin(), 100.0);
                };
                let size = bounds.max - bounds.min;
                // In the turned frame x is up and y to the left.
                let width =
                    (size.y + 2.0 * MARGIN).max((size.x + 2.0 * MARGIN) * area.width / area.height);
                around(
                    turned.to_world(&bounds.center()),
                    width.clamp(MIN_WIDTH, MAX_WIDTH),
                )
            }
        }
    }

    /// The same from farther away, so that these points are on the page, with room around them for a vehicle and what stands at the edges of maps.
    #[must_use]
    pub fn with(self, points: impl IntoIterator<Item = Point>) -> Self {
        const ROOM: f64 = 8.0;
        let half = points.into_iter().map(|point| {
            let local = self.frame.to_local(&point);
            let ratio = self.area.width / self.area.height;
            (local.y.abs() + ROOM).max((local.x.abs() + ROOM) * ratio)
        });
        let width = half.fold(self.width(), |width, half| width.max(2.0 * half));
        Self {
            scale: self.area.width / width.min(MAX_WIDTH),
            ..self
        }
    }

    /// Where a point of the world is on the page.
    #[must_use]
    pub fn at(&self, p: &Point) -> Spot {
        let local = self.frame.to_local(p);
        let (x, y) = self.area.center();
        (x - local.y * self.scale, y - local.x * self.scale)
    }

    /// The same for many.
    #[must_use]
    pub fn all<'a>(&self, points: impl IntoIterator<Item = &'a Point>) -> Vec<Spot> {
        points.into_iter().map(|p| self.at(p)).collect()
    }

    /// The part of the world that it shows, with the few points around it that lines and signs reach.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        let half = |points: f64| (points / 2.0 + OUTER_MARGIN) / self.scale;
        Viewport::new(self.frame, (half(self.area.width), half(self.area.height)))
    }

    /// Metres from left to right.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.area.width / self.scale
    }
}

/// Room around everything, metres.
const MARGIN: f64 = 12.0;

/// What lies so far outside may be seen, points.
const OUTER_MARGIN: f64 = 4.0;

/// What is drawn: a scenario, with its ego if it has one.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// The same with its ego.
    pub scene: Option<&'a Scene>,
}

/// The two motions of an obstacle that moves in another way in a variant of a scenario.
#[derive(Debug, Clone, Copy)]
pub struct Variation<'a> {
    /// It, as it was recorded.
    pub recorded: &'a Obstacle,
    /// It, as it was changed.
    pub changed: &'a Obstacle,
    /// The last step before the two part.
    pub from: i64,
    /// Whether the changed one is the one that is in the picture.
    pub shows_changed: bool,
}

/// Both motions of each attacker of a variant; of none where it is no variant.
#[derive(Debug, Clone, Copy, Default)]
pub struct Variations<'a>([Option<Variation<'a>>; MOST_VARIED]);

/// The attackers of a variant that are drawn, at most.
const MOST_VARIED: usize = 3;

impl<'a> Variations<'a> {
    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Variation<'a>> {
        self.0.iter().flatten()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// The place of an obstacle among the attackers.
    #[must_use]
    pub fn place_of(&self, obstacle: i64) -> Option<usize> {
        self.iter().position(|both| both.changed.id == obstacle)
    }

    /// That of an obstacle.
    #[must_use]
    pub fn get(&self, obstacle: i64) -> Option<&Variation<'a>> {
        self.iter().find(|both| both.changed.id == obstacle)
    }

    /// Whether the changed motions are in the picture; `None` where there are none.
    #[must_use]
    pub fn shows_changed(&self) -> Option<bool> {
        Some(self.iter().next()?.shows_changed)
    }
}

impl<'a> FromIterator<Variation<'a>> for Variations<'a> {
    fn from_iter<T: IntoIterator<Item = Variation<'a>>>(all: T) -> Self {
        let mut found = Self::default();
        for (place, both) in found.0.iter_mut().zip(all) {
            *place = Some(both);
        }
        found
    }
}

impl<'a> Subject<'a> {
    /// A scenario with its ego.
    #[must_use]
    pub fn with_ego(scene: &'a Scene) -> Self {
        Self {
            scenario: &scene.scenario,
            scene: Some(scene),
        }
    }

    /// The steps that there is something to see at.
    #[must_use]
    pub fn steps(&self) -> std::ops::Range<i64> {
        match self.scene {
            Some(scene) => scene.steps(),
            None => self.scenario.steps(),
        }
    }

    /// The direction that is up on a map, radians: north, or the heading of the ego at a step.
    pub(super) fn up(&self, ego_up: bool, step: i64) -> f64 {
        let ego = self.scene.and_then(|scene| scene.ego.track.at(step));
        match ego {
            Some(motion) if ego_up => motion.pose.heading,
            _ => std::f64::consts::FRAC_PI_2,
        }
    }

    /// Everyone but the ego.
    pub fn others(&self) -> impl Iterator<Item = &'a Obstacle> + use<'a> {
        let ego = self.scene.map(|scene| scene.ego.id);
        let obstacles = self.scenario.obstacles.iter();
        obstacles.filter(move |o| Some(o.id) != ego)
    }

    /// Where any participant ever is; without participants, the road.
    fn everywhere(&self) -> Vec<Point> {
        let ego = self.scene.into_iter().map(|scene| &scene.ego.track);
        let tracks = self.scenario.obstacles.iter().map(Obstacle::track);
        let places = ego.chain(tracks).flat_map(|t| t.iter());
        let places: Vec<Point> = places.map(|(_, m)| m.pose.position).collect();
        if places.len() > 1 {
            return places;
        }
        let lanelets = self.scenario.network.lanelets.iter();
        let borders = lanelets.flat_map(|l| l.left.points.iter().chain(&l.right.points));
        borders.copied().chain(places).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_view_goes_back_until_all_points_are_on_the_page_and_no_nearer() {
        let area = Area {
            x: 0.0,
            y: 0.0,
            width: 200.0,
            height: 100.0,
        };
        let view = View {
            frame: Pose::new(7.0, -3.0, 0.4),
            scale: 4.0,
            area,
        };
        let world = |x, y| view.frame.to_world(&Point::new(x, y));
        assert_eq!(view.with([world(3.0, 10.0)]), view);
        for far in [world(40.0, 0.0), world(0.0, -70.0), world(-30.0, 90.0)] {
            let wide = view.with([far]);
            let (x, y) = wide.at(&far);
            assert!(
                (0.0..=200.0).contains(&x) && (0.0..=100.0).contains(&y),
                "{x} {y}"
            );
            assert!(wide.scale < view.scale);
        }
    }

    #[test]
    fn metres_are_the_same_in_both_directions_and_left_stays_left() {
        let area = Area {
            x: 10.0,
            y: 20.0,
            width: 200.0,
            height: 100.0,
        };
        for heading in [std::f64::consts::FRAC_PI_2, 0.0, 2.1] {
            let frame = Pose::new(7.0, -3.0, heading);
            let view = View {
                frame,
                scale: 4.0,
                area,
            };
            let middle = view.at(&frame.position);
            assert_eq!(middle, (110.0, 70.0));
            let ahead = view.at(&frame.to_world(&Point::new(10.0, 0.0)));
            let left = view.at(&frame.to_world(&Point::new(0.0, 10.0)));
            let near = |a: Spot, b: Spot| (a.0 - b.0).abs() + (a.1 - b.1).abs() < 1e-9;
            assert!(near(ahead, (110.0, 30.0)), "{ahead:?}");
            assert!(near(left, (70.0, 70.0)), "{left:?}");
        }
    }

    #[test]
    fn views_are_read_and_nonsense_is_refused() {
        assert_eq!(MapExtent::parse("all"), Ok(MapExtent::All));
        assert_eq!(
            MapExtent::parse("ego,80"),
            Ok(MapExtent::Ego { width: 80.0 })
        );
        let around = MapExtent::parse("-12.5, 3e1,40").unwrap();
        let MapExtent::Around { center, width } = around else {
            panic!("{around:?}")
        };
        assert_eq!((center.x, center.y, width), (-12.5, 30.0, 40.0));
        for wrong in [
            "", "me", "1,2", "1,2,0", "1,2,nan", "ego,-3", "1,2,3,4", "inf,2,3",
        ] {
            assert!(
                MapExtent::parse(wrong).unwrap_err().contains("X,Y,WIDTH"),
                "{wrong}"
            );
        }
    }
}
