//! A storyboard for models that see: moments of a window from above, with ids, trails and arrows of velocity. It shows
//! what its panels name and what was up to each, and nothing of what comes later or of where the scene comes from.

use super::Color;
use super::display::{Anchor, Area, Picture, Stroke, Text};
use super::figure::PIXEL;
use super::map::Map;
use super::palette::Palette;
use super::scene::{
    Basemap, Body, LineStyle, MapRequest, MapScene, Overlay, Owner, Trail, TrailSpan,
};
use super::view::{Subject, Variations, View};
use nearmiss_base::geometry::{Pose, Vector};
use nearmiss_scene::scenario::Scene;

/// A moment of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoryboardPanel {
    /// The time step.
    pub step: i64,
    /// The obstacles that are drawn.
    pub obstacles: Vec<i64>,
}

/// What a storyboard shows.
#[derive(Debug, Clone, Copy)]
pub struct Storyboard<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The moments, in order.
    pub panels: &'a [StoryboardPanel],
    /// The step from which trails are drawn.
    pub from: i64,
    /// Whether north is up, and not the ego's heading.
    pub north_up: bool,
    /// Whether steps and times are those of the recording; otherwise times are relative to the last moment.
    pub recorded_times: bool,
    /// Whether contacts are marked.
    pub contact: bool,
}

/// Width of a storyboard and most of its height, pixels: no provider that is known makes a picture of this size smaller
/// before a model sees it.
const SIZE: (u32, u32) = (1152, 768);

/// Height of the legend, pixels.
const LEGEND: u32 = 32;

/// Half of what a panel shows from side to side, metres: at least, and beyond the farthest body.
const MIN_EXTENT: f64 = 16.0;
const MARGIN: f64 = 5.0;

/// The same of the close-up of the last moment, in which small distances can be told.
const CLOSE_UP: f64 = 8.0;

/// Obstacles that have colours of their own.
const COLORED: usize = 5;

/// Seconds of motion that an arrow shows, and the slowest velocity that has one, m/s.
const ARROW: (f64, f64) = (0.5, 0.3);

impl Storyboard<'_> {
    /// Columns and rows of so many panels.
    fn shape(count: usize) -> (usize, usize) {
        match count {
            0..=1 => (1, 1),
            2 => (2, 1),
            3 => (3, 1),
            4 => (2, 2),
            5..=6 => (3, 2),
            7..=8 => (4, 2),
            n => (4, n.div_ceil(4)),
        }
    }

    /// Width and height of one with so many moments, pixels.
    #[must_use]
    pub fn size(moments: usize) -> (u32, u32) {
        let (columns, rows) = Self::shape(moments + 1);
        let panel = (SIZE.1 - LEGEND) / rows as u32;
        let width = SIZE.0.min(panel * columns as u32);
        let panel = panel.min(width / columns as u32 + 24);
        (width, panel * rows as u32 + LEGEND)
    }

    /// Draws it; the same scene up to the last panel is always the same picture.
    #[must_use]
    pub fn picture(&self) -> Picture {
        // Lanes are to be seen as clearly as bodies.
        let palette = Palette {
            road: Color::hex(0xe4e7ea),
            lane: Color::hex(0x4a5056),
            lane_dashed: Color::hex(0x5f666d),
            ..Palette::paper()
        };
        let (columns, rows) = Self::shape(self.panels.len() + 1);
        let (width, height) = Self::size(self.panels.len());
        let points = |pixels: u32| f64::from(pixels) * PIXEL;
        let mut picture = Picture::new((points(width), points(height)), palette.background);
        let basemap = Basemap::new(&self.scene.scenario);
        let colored = self.colored();
        let (wide, high) = (
            points(width) / columns as f64,
            points(height - LEGEND) / rows as f64,
        );
        let (half, last) = (self.half(), self.panels.last());
        let moments = self.panels.iter().map(|panel| (panel, half, ""));
        let closer = last.map(|panel| (panel, CLOSE_UP, ", close-up"));
        for (place, (panel, half, more)) in moments.chain(closer).enumerate() {
            let (row, column) = (place / columns, place % columns);
            let area = Area {
                x: wide * column as f64,
                y: high * row as f64,
                width: wide,
                height: high,
            }
            .grown(-1.5);
            let view = View {
                frame: self.frame(panel.step),
                scale: area.width.min(area.height) / (2.0 * half),
                area,
            };
            let title = self.time(panel.step) + more;
            self.panel(
                &mut picture,
                &palette,
                &basemap,
                (&colored, title),
                panel,
                view,
            );
        }
        let below = points(height - LEGEND);
        self.legend(&mut picture, &palette, below, points(LEGEND));
        picture
    }

    /// When a step is, as descriptions have it.
    fn time(&self, step: i64) -> String {
        if self.recorded_times {
            let seconds = step as f64 * self.scene.scenario.dt();
            return format!("step {step}, t = {seconds:.2} s");
        }
        let last = self.panels.last().map_or(step, |panel| panel.step);
        let seconds = (step - last) as f64 * self.scene.scenario.dt();
        // Never a negative zero.
        format!("t = {:.2} s", if step == last { 0.0 } else { seconds })
    }

    /// What is in the middle of a panel, and up: of one without ego what is in that of the next one.
    fn frame(&self, step: i64) -> Pose {
        let later = self.panels.iter().map(|panel| panel.step);
        let mut steps = std::iter::once(step).chain(later.filter(|s| *s > step));
        let ego = steps.find_map(|step| self.scene.ego.track.at(step));
        let pose = ego.map_or(Pose::new(0.0, 0.0, 0.0), |motion| motion.pose);
        if self.north_up {
            Pose {
                heading: std::f64::consts::FRAC_PI_2,
                ..pose
            }
        } else {
            pose
        }
    }

    /// Half of what a panel shows from side to side, metres: everyone who is drawn, in all panels.
    fn half(&self) -> f64 {
        let far = self.distances().map(|(_, far)| far).fold(0.0, f64::max);
        (far + MARGIN).max(MIN_EXTENT)
    }

    /// Everyone in every panel, and how far its centre is from the ego's, metres.
    fn distances(&self) -> impl Iterator<Item = (i64, f64)> {
        self.panels.iter().flat_map(move |panel| {
            let ego = self.scene.ego.track.at(panel.step);
            let drawn = move |id: &i64| {
                let other = self.scene.scenario.obstacle(*id)?.motion_at(panel.step)?;
                Some((*id, (other.pose.position - ego?.pose.position).norm()))
            };
            panel.obstacles.iter().filter_map(drawn)
        })
    }

    /// Those who come nearest to the ego, by their ids.
    fn colored(&self) -> Vec<i64> {
        let mut nearest: Vec<(i64, f64)> = Vec::new();
        for (id, far) in self.distances() {
            match nearest.iter_mut().find(|(known, _)| *known == id) {
                Some((_, least)) => *least = least.min(far),
                None => nearest.push((id, far)),
            }
        }
        nearest.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let mut ids: Vec<i64> = nearest.into_iter().take(COLORED).map(|n| n.0).collect();
        ids.sort_unstable();
        ids
    }

    /// Draws a moment.
    fn panel(
        &self,
        picture: &mut Picture,
        palette: &Palette,
        basemap: &Basemap,
        (colored, title): (&[i64], String),
        panel: &StoryboardPanel,
        view: View,
    ) {
        let past = TrailSpan {
            past: None,
            future: Some(0.0),
        };
        let request = MapRequest {
            subject: Subject {
                scenario: &self.scene.scenario,
                scene: Some(self.scene),
            },
            basemap,
            step: panel.step,
            viewport: view.viewport(),
            highlighted: colored,
            series: None,
            variations: Variations::default(),
            trails: [past; 2],
        };
        let mut seen = MapScene::new(&request);
        let drawn = |owner: Owner| match owner {
            Owner::Ego => true,
            Owner::Obstacle(id) => panel.obstacles.contains(&id),
        };
        // Where the ego is meant to go and where others may come to be are told by no text frame either.
        seen.goals.clear();
        seen.regions.clear();
        if !self.contact {
            seen.contacts.clear();
        }
        seen.bodies.retain(|body| drawn(body.owner));
        seen.trails.retain(|trail| drawn(trail.owner));
        let trails = std::mem::take(&mut seen.trails);
        seen.trails = trails.into_iter().map(|trail| self.until(trail)).collect();
        let everyone = seen.bodies.iter().chain(&seen.ego);
        seen.overlays = everyone.filter_map(arrow).collect();
        let map = Map {
            scene: &seen,
            seconds: 0.0,
            dt: self.scene.scenario.dt(),
            attackers: Vec::new(),
            workbench: None,
            palette,
            view,
            letters: 9.0,
            scale_bar: true,
            title: Some(title),
        };
        map.draw(picture);
    }

    /// A trail from the beginning of the window to the moment, without what is recorded of the future.
    fn until<'t>(&self, trail: Trail<'t>) -> Trail<'t> {
        let begin = trail.past.partition_point(|(step, _)| *step < self.from);
        Trail {
            past: &trail.past[begin..],
            future: &[],
            ..trail
        }
    }

    /// What the signs mean, in a row.
    fn legend(&self, picture: &mut Picture, palette: &Palette, top: f64, height: f64) {
        let letters = 9.0;
        let middle = top + height / 2.0;
        let mut x = 6.0;
        let mut entry = |p: &mut Picture, words: &str, sign: &dyn Fn(&mut Picture, f64) -> f64| {
            let right = sign(p, x);
            let at = (right + 4.0, middle + letters * 0.35);
            p.text(Text::new(at, words, letters, palette.text).anchored(Anchor::Start));
            x = at.0 + Text::width(words, letters) + 16.0;
        };
        let body = |color: Color| {
            move |p: &mut Picture, x: f64| {
                let area = Area {
                    x,
                    y: middle - 4.0,
                    width: 18.0,
                    height: 8.0,
                };
                let edge = color.towards(palette.text, 0.45);
                p.rectangle(&area, Some(color), Some(Stroke::new(edge, 0.45)));
                area.right()
            }
        };
        picture.group("legend", None, |p| {
            entry(p, "ego", &body(palette.ego));
            entry(p, "obstacle, with its id", &body(palette.emphasised(0)));
            entry(p, "way so far", &|p, x| {
                let line = [(x, middle), (x + 20.0, middle)];
                p.line(&line, Stroke::new(palette.text.at(0.75), 0.9).rounded());
                x + 20.0
            });
            entry(p, "way in 0.5 s at its velocity", &|p, x| {
                let tip = (x + 22.0, middle);
                let head = [
                    (tip.0 - 4.5, middle - 3.0),
                    tip,
                    (tip.0 - 4.5, middle + 3.0),
                ];
                let stroke = || Stroke::new(palette.text, 1.4).rounded();
                p.line(&[(x, middle), tip], stroke());
                p.line(&head, stroke());
                tip.0
            });
        });
    }
}

/// The way that a body would go at its velocity, from its front.
fn arrow(body: &Body<'_>) -> Option<Overlay> {
    let velocity = body.motion.velocity_vector();
    let (seconds, slowest) = ARROW;
    let speed = velocity.norm();
    if speed < slowest || body.stands {
        return None;
    }
    let ahead: Vector = velocity * seconds;
    let front = if body.motion.velocity >= 0.0 {
        body.point(body.along.1, 0.0)
    } else {
        body.point(body.along.0, 0.0)
    };
    let tip = front + ahead;
    let along = velocity / speed;
    let across = Vector::new(-along.y, along.x);
    let deep = (0.35 * speed * seconds).min(0.9);
    let side = |left: f64| tip - along * deep + across * (left * deep * 0.6);
    let points = vec![front, tip, side(1.0), tip, side(-1.0)];
    Some(Overlay::path(body.role, LineStyle::Thick, points))
}
