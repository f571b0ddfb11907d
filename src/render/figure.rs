//! A figure of a scene: the map, plots of measures over time, or both, for any step; the map alone on a page.

use nearmiss_base::geometry::{Point, Pose};
use nearmiss_formats::Forecast;
use nearmiss_scene::metrics::{
    Context, CriticalMoment, Headline, MEASURES, Measure, Series, Thresholds,
};
use nearmiss_scene::scenario::{Scene, Window, WindowRule};

use super::display::{Area, Picture, Provenance};
use super::map::{Map, WorkbenchMap};
use super::palette::Palette;
use super::plot::Plot;
use super::scene::{
    Basemap, LineStyle, MapRequest, MapScene, Overlay, Path, Role, TrailSpan, Viewport,
};
use super::view::{MapExtent, Subject, Variations, View};

/// What is on a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FigureContent {
    /// The map from above.
    Map,
    /// Measures over time.
    Plot,
    /// The map, and measures over time below it.
    Both,
}

/// How a figure looks.
#[derive(Debug, Clone)]
pub struct FigureOptions {
    /// What is on it.
    pub what: FigureContent,
    /// Which part of the map.
    pub seen: MapExtent,
    /// Whether the ego drives upwards, and not north.
    pub ego_up: bool,
    /// Obstacles that are pointed out; the most dangerous one where none are named.
    pub obstacles: Vec<i64>,
    /// The measures that are plotted.
    pub measures: Vec<&'static Measure>,
    /// The question whose window plots shade.
    pub window: Option<WindowRule>,
    /// Width and height, points; the height follows from what is on it where it is not given.
    pub size: (f64, Option<f64>),
    /// Colours.
    pub palette: Palette,
}

/// What is shown of the motion of obstacles that are not pointed out.
const TRAIL: TrailSpan = TrailSpan {
    past: Some(2.0),
    future: Some(0.0),
};

/// Points of a millimetre.
pub const MILLIMETRE: f64 = 72.0 / 25.4;
/// Points of a pixel, of which an inch has 96.
pub const PIXEL: f64 = 72.0 / 96.0;
/// Width of a column of a paper, points.
pub const COLUMN: f64 = 85.0 * MILLIMETRE;

impl Default for FigureOptions {
    /// A map in a column of a paper.
    fn default() -> Self {
        Self {
            what: FigureContent::Map,
            seen: MapExtent::Usual,
            ego_up: false,
            obstacles: Vec::new(),
            measures: MEASURES.iter().filter(|m| m.id == "distance").collect(),
            window: None,
            size: (COLUMN, None),
            palette: Palette::paper(),
        }
    }
}

/// Why there is no figure.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FigureError {
    /// Nothing can be plotted without an ego.
    #[error("measures need an ego, but there is none; choose one, or draw the map")]
    NoEgo,
    /// No obstacle has this id.
    #[error("no obstacle {0} in the scenario")]
    NoSuchObstacle(i64),
    /// An obstacle is the ego, and cannot be highlighted beside it.
    #[error("{0} is the ego and cannot be highlighted as an obstacle")]
    IsEgo(i64),
}

/// A figure that can be drawn at any step.
pub struct Figure<'a> {
    subject: Subject<'a>,
    basemap: Basemap,
    variations: Variations<'a>,
    forecasts: &'a [Forecast],
    look: FigureOptions,
    thresholds: &'a Thresholds,
    series: Option<Series>,
    name: &'a str,
    telling: i64,
    moments: Vec<CriticalMoment>,
    contact: Option<i64>,
}

impl<'a> Figure<'a> {
    /// Measures what it needs; `name` is that of the scenario.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub fn new(
        subject: Subject<'a>,
        name: &'a str,
        mut look: FigureOptions,
        thresholds: &'a Thresholds,
    ) -> Result<Self, FigureError> {
        let ego = subject.scene.map(|scene| scene.ego.id);
        for &id in &look.obstacles {
            if subject.scenario.obstacle(id).is_none() {
                return Err(FigureError::NoSuchObstacle(id));
            }
            if Some(id) == ego {
                return Err(FigureError::IsEgo(id));
            }
        }
        if look.what != FigureContent::Map && subject.scene.is_none() {
            return Err(FigureError::NoEgo);
        }
        let mut telling = subject.steps().start;
        let (mut series, mut contact, mut moments) = (None, None, Vec::new());
        if let Some(scene) = subject.scene {
            let context = Context::under(scene, thresholds);
            let headline = Headline::from_context(&context);
            contact = headline.contact.map(|contact| contact.step);
            if let Some(worst) = headline.worst() {
                telling = worst.step;
                if look.obstacles.is_empty() {
                    look.obstacles.push(worst.obstacle);
                }
            }
            if look.what != FigureContent::Map {
                series = Some(Series::from_context(&context, look.measures.clone()));
            }
            moments = headline.moments;
        }
        Ok(Self {
            subject,
            basemap: Basemap::new(subject.scenario),
            variations: Variations::default(),
            forecasts: &[],
            look,
            thresholds,
            series,
            name,
            telling,
            moments,
            contact,
        })
    }

    /// The same with both motions of each attacker of a variant; the attackers are pointed out.
    #[must_use]
    pub fn with_variations(mut self, variations: Variations<'a>) -> Self {
        let pointed_out = &mut self.look.obstacles;
        let ids = variations.iter().map(|both| both.changed.id);
        let new: Vec<i64> = ids.filter(|id| !pointed_out.contains(id)).collect();
        pointed_out.splice(0..0, new);
        self.variations = variations;
        self
    }

    /// The same with the trajectories of a prediction over the map.
    #[must_use]
    pub fn with_forecasts(mut self, forecasts: &'a [Forecast]) -> Self {
        self.forecasts = forecasts;
        self
    }

    /// The step that tells most: see [`Headline::worst`]; without an ego the first one.
    #[must_use]
    pub fn telling_step(&self) -> i64 {
        self.telling
    }

    /// The steps that it can be drawn at.
    #[must_use]
    pub fn steps(&self) -> std::ops::Range<i64> {
        self.subject.steps()
    }

    /// The obstacles that are pointed out.
    #[must_use]
    pub fn obstacles(&self) -> &[i64] {
        &self.look.obstacles
    }

    /// Draws it at a step.
    #[must_use]
    pub fn at(&self, step: i64) -> Picture {
        let look = &self.look;
        let (width, height) = look.size;
        let letters = (width / 34.0).clamp(5.5, 10.0);
        let panels = look.measures.len().max(1) as f64;
        let plot_height = panels * 0.36 * width + 5.0 * letters;
        let (map_height, plot_height) = match (look.what, height) {
            (FigureContent::Map, height) => (height.unwrap_or(0.68 * width), 0.0),
            (FigureContent::Plot, height) => (0.0, height.unwrap_or(plot_height)),
            (FigureContent::Both, None) => (0.62 * width, plot_height),
            (FigureContent::Both, Some(all)) => {
                let part = panels / (panels + 1.4);
                (all * (1.0 - part), all * part)
            }
        };
        let mut picture = Picture::new((width, map_height + plot_height), look.palette.background);
        picture.provenance = self.provenance(step);
        let emphasised = &look.obstacles;
        if map_height > 0.0 {
            // Half of the frame's line would be cut off otherwise.
            let area = Area {
                x: 0.0,
                y: 0.0,
                width,
                height: map_height,
            }
            .grown(-0.25);
            let seen = self.extent(area);
            let view = View::new(seen, look.ego_up, &self.subject, step, area);
            self.draw_map(&mut picture, step, view, letters, true);
        }
        if let Some(series) = self.series.as_ref().filter(|_| plot_height > 0.0) {
            let space = if map_height > 0.0 { 4.0 } else { 0.0 };
            let plot = Plot {
                series,
                dt: self.subject.scenario.dt(),
                cursor: Some(step),
                window: self.window(step),
                contact: self.contact,
                emphasised,
                thresholds: self.thresholds,
                palette: &look.palette,
                area: Area {
                    x: 0.0,
                    y: map_height + space,
                    width,
                    height: plot_height - space,
                },
                letters,
            };
            plot.draw(&mut picture);
        }
        picture
    }

    /// Which part of the map is seen in an area: of the same width at all steps, so that films stand still.
    pub(super) fn extent(&self, area: Area) -> MapExtent {
        let (look, telling) = (&self.look, self.telling);
        if look.seen != MapExtent::Usual || self.subject.scene.is_none() {
            return look.seen;
        }
        let view = View::new(look.seen, look.ego_up, &self.subject, telling, area);
        MapExtent::Ego {
            width: view.with(self.pointed_out(telling)).width(),
        }
    }

    /// Where the obstacles are at a step that are pointed out.
    fn pointed_out(&self, step: i64) -> impl Iterator<Item = Point> {
        let everyone = self.subject.scene.into_iter().flat_map(Scene::participants);
        let wanted = |id: i64| self.look.obstacles.contains(&id);
        let motions = everyone.filter(move |p| wanted(p.obstacle.id));
        motions.filter_map(move |p| Some(p.at(step)?.pose.position))
    }

    /// Draws the map at a step into a part of a picture, with letters of this size, points, and a scale bar or not.
    pub(super) fn draw_map(
        &self,
        picture: &mut Picture,
        step: i64,
        view: View,
        letters: f64,
        scale_bar: bool,
    ) {
        let emphasised = &self.look.obstacles;
        let request = MapRequest {
            subject: self.subject,
            basemap: &self.basemap,
            step,
            viewport: view.viewport(),
            highlighted: emphasised,
            series: None,
            variations: self.variations,
            trails: [TRAIL, TrailSpan::WHOLE],
        };
        let dt = self.subject.scenario.dt();
        let mut scene = MapScene::new(&request);
        let forecasts = self.forecasts.iter();
        scene
            .overlays
            .extend(forecasts.map(|forecast| self.overlay(forecast)));
        let attackers = self.variations.iter().map(|both| both.changed.id);
        let place = |id: i64| emphasised.iter().position(|&e| e == id);
        let map = Map {
            scene: &scene,
            seconds: step as f64 * dt,
            dt,
            attackers: attackers.map(place).collect(),
            palette: &self.look.palette,
            workbench: None,
            view,
            letters,
            scale_bar,
            title: None,
        };
        map.draw(picture);
    }

    /// A line of a prediction, in the colour of its obstacle.
    fn overlay(&self, forecast: &Forecast) -> Overlay {
        let pointed_out = |id: i64| self.look.obstacles.iter().position(|&other| other == id);
        let role = match forecast.id {
            Some(id) if self.is_ego(id) => Role::Ego,
            Some(id) => match pointed_out(id) {
                Some(place) => Role::Highlighted(place),
                None if self.subject.scenario.obstacle(id).is_some() => Role::Obstacle,
                None => Role::Prediction,
            },
            None => Role::Prediction,
        };
        Overlay::Path(Path {
            role,
            style: LineStyle::Solid,
            opacity: forecast.opacity(),
            points: forecast.points.clone(),
        })
    }

    /// Whether an id is the ego's.
    pub(super) fn is_ego(&self, id: i64) -> bool {
        self.subject.scene.is_some_and(|scene| scene.ego.id == id)
    }

    /// The lines of a prediction.
    pub(super) fn forecasts(&self) -> &'a [Forecast] {
        self.forecasts
    }

    /// Both motions of a variant's attackers.
    pub(super) fn variations(&self) -> &Variations<'a> {
        &self.variations
    }

    /// The most severe moment with each obstacle, the most severe first.
    pub(super) fn moments(&self) -> &[CriticalMoment] {
        &self.moments
    }

    /// The values of its measures, if it has any.
    pub(super) fn series(&self) -> Option<&Series> {
        self.series.as_ref()
    }

    /// From where on values are dangerous.
    pub(super) fn thresholds(&self) -> &'a Thresholds {
        self.thresholds
    }

    /// What lies below everything.
    pub(super) fn basemap(&self) -> &Basemap {
        &self.basemap
    }

    /// What is drawn.
    pub(super) fn subject(&self) -> Subject<'a> {
        self.subject
    }

    /// How it looks.
    pub(super) fn look(&self) -> &FigureOptions {
        &self.look
    }

    /// The name of its scenario.
    pub(super) fn name(&self) -> &'a str {
        self.name
    }

    /// The window that plots shade at a step.
    fn window(&self, step: i64) -> Option<Window> {
        let rule = self.look.window.filter(|_| self.series.is_some())?;
        Some(rule.at(self.subject.scene?, step))
    }

    fn provenance(&self, step: i64) -> Provenance {
        let scenario = self.subject.scenario;
        let seconds = step as f64 * scenario.dt();
        let name = self.name;
        let what = match self.look.what {
            FigureContent::Map => "The scene from above",
            FigureContent::Plot => "Measures over time",
            FigureContent::Both => "The scene from above and measures over time",
        };
        let mut facts = vec![
            (
                "program",
                concat!("nearmiss ", env!("CARGO_PKG_VERSION")).to_string(),
            ),
            ("scenario", name.to_string()),
            ("sha256", scenario.hash.to_string()),
            ("step", step.to_string()),
            ("time", format!("{seconds:.3} s")),
        ];
        let ego = self.subject.scene.map(|scene| scene.ego.to_string());
        facts.push(("ego", ego.unwrap_or_else(|| "none".into())));
        if !self.look.obstacles.is_empty() {
            let ids: Vec<String> = self.look.obstacles.iter().map(i64::to_string).collect();
            facts.push(("obstacles", ids.join(", ")));
        }
        let varied = self.variations.iter();
        let varied: Vec<String> = varied
            .map(|both| format!("obstacle {} after step {}", both.changed.id, both.from))
            .collect();
        if !varied.is_empty() {
            let words = format!("{}, as recorded and as changed", varied.join(" and "));
            facts.push(("variant", words));
        }
        if self.look.what != FigureContent::Map {
            let ids: Vec<&str> = self.look.measures.iter().map(|m| m.id).collect();
            facts.push(("measures", ids.join(", ")));
        }
        if let Some(window) = self.window(step) {
            let words = format!("steps {} to {}", window.first(), window.last());
            facts.push(("window", words));
        }
        Provenance {
            title: format!("{name}, t = {seconds:.1} s"),
            description: format!(
                "{what} of the scenario {name} at time step {step} ({seconds:.1} s)."
            ),
            facts,
        }
    }
}

/// Size of the letters, points.
const LETTERS: f64 = 8.0;

/// A page that a map fills.
#[derive(Debug, Clone, Copy)]
pub struct MapPage {
    /// Width and height, pixels.
    pub pixels: (u32, u32),
    /// Height of a line of text beside the map, pixels: its letters are about as large.
    pub line: f64,
    /// What is in the middle, and the direction that is up.
    pub frame: Pose,
    /// Metres from left to right.
    pub width: f64,
}

impl MapPage {
    /// Pixels of a point.
    #[must_use]
    pub fn scale(&self) -> f64 {
        (self.line * 0.6 / LETTERS).max(0.5)
    }

    /// Dots per inch at which the page has its size in pixels.
    #[must_use]
    pub fn dpi(&self) -> f64 {
        72.0 * self.scale()
    }

    fn view(&self) -> View {
        let points = |pixels: u32| f64::from(pixels) / self.scale();
        let area = Area {
            x: 0.0,
            y: 0.0,
            width: points(self.pixels.0),
            height: points(self.pixels.1),
        };
        View {
            frame: self.frame,
            scale: area.width / self.width,
            area,
        }
    }

    /// The part of the world that is seen.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        self.view().viewport()
    }

    /// Draws the scene that was made for [`MapPage::viewport`].
    #[must_use]
    pub fn draw(
        &self,
        request: &MapRequest<'_>,
        scene: &MapScene<'_>,
        palette: &Palette,
        look: WorkbenchMap<'_>,
    ) -> Picture {
        let view = self.view();
        let map = Map {
            scene,
            seconds: request.step as f64 * request.subject.scenario.dt(),
            dt: request.subject.scenario.dt(),
            attackers: Vec::new(),
            palette,
            workbench: Some(look),
            view,
            letters: LETTERS,
            scale_bar: true,
            title: None,
        };
        let size = (view.area.width, view.area.height);
        let mut picture = Picture::new(size, look.theme.map_ground);
        map.draw(&mut picture);
        picture
    }
}
