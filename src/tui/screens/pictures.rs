//! Picker for the picture to save.

use ratatui::Frame;
use ratatui::layout::Rect;

use super::Step;
use super::picker::{self, Choice};
use crate::loaded::{PictureJob, PictureKind};
use crate::message::Effect;
use crate::model::{Model, Pane, Picker, matching};
use crate::widgets::{picker as list, window};
use nearmiss_render::{FigureContent, FigureOptions, Format, MapExtent};

/// Pictures by name.
#[derive(Debug)]
pub struct Pictures;

/// Opens the list, where there is something to be seen on a picture.
pub fn open(model: &mut Model) {
    if model.opened.is_none() {
        return model.say("no scenario is open");
    }
    picker::open(model, Pictures);
}

impl Choice for Pictures {
    fn count(&self, model: &Model, picker: &Picker) -> usize {
        pictures_shown(picker, model).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let shown = pictures_shown(picker, model);
        let (Some(offer), Some(opened)) = (shown.get(picker.selected), &model.opened) else {
            return Step::close();
        };
        let kind = offer.kind;
        let question = model.prompt.question.as_ref();
        let asked = question.and_then(|question| question.picture.clone());
        if kind == PictureKind::Question && asked.is_none() {
            model.say("this question has no picture; choose the frame picture or ego+picture");
            return Step::close();
        }
        if matches!(kind, PictureKind::Plot | PictureKind::Both) && opened.scene.is_none() {
            let why = model.without_ego();
            model.say(format!("nothing to plot: {why}"));
            return Step::close();
        }
        let job = PictureJob {
            kind,
            format: offer.format,
            name: opened.name.clone(),
            scenario: opened.scenario.clone(),
            scene: opened.scene.clone(),
            // As on the map, where the layer is shown.
            variant: { opened.variant.clone() }.filter(|_| model.map.layers.variant),
            step: model.clock.step(),
            look: look(model, kind),
            thresholds: model.thresholds.clone(),
            folder: model.config.pictures.clone(),
            screen: Ok(None),
            shown: asked,
        };
        if kind == PictureKind::Animation {
            model.say("the animation is being drawn");
        }
        Step::Close(vec![Effect::Picture(Box::new(job))])
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let inner = window::window(frame, screen, model, "save a figure or picture", (64, 16));
        let rows = pictures_shown(picker, model)
            .into_iter()
            .map(|offer| (offer.name.to_string(), offer.format.name().to_string()));
        list::draw(frame, inner, model, picker, &rows.collect::<Vec<_>>());
    }
}

/// As the map and the plot are seen now, in the colours of a paper.
fn look(model: &Model, kind: PictureKind) -> FigureOptions {
    let (columns, _) = model.drawn.map_size();
    let width = (model.camera.cell * f64::from(columns)).max(2.0);
    let seen = if model.camera.follow {
        MapExtent::Ego { width }
    } else {
        MapExtent::Around {
            center: model.camera.center,
            width,
        }
    };
    let ego = model.scene().map(|scene| scene.ego.id);
    let mut obstacles: Vec<i64> = model.picked.into_iter().collect();
    obstacles.extend(
        model
            .plot
            .marked
            .iter()
            .filter(|id| Some(**id) != model.picked),
    );
    obstacles.retain(|id| Some(*id) != ego);
    FigureOptions {
        what: match kind {
            PictureKind::Plot => FigureContent::Plot,
            PictureKind::Both => FigureContent::Both,
            _ => FigureContent::Map,
        },
        seen,
        ego_up: model.camera.ego_up,
        obstacles,
        measures: vec![model.plot.measure],
        window: Some(model.window_rule()),
        ..FigureOptions::default()
    }
}

/// A picture that can be chosen.
#[derive(Debug)]
struct PictureOffer {
    /// Its subject.
    kind: PictureKind,
    /// How it is written.
    format: Format,
    /// Its name.
    name: &'static str,
}

const fn offer(kind: PictureKind, format: Format, name: &'static str) -> PictureOffer {
    PictureOffer { kind, format, name }
}

const OFFERS: &[PictureOffer] = &[
    offer(PictureKind::Map, Format::Svg, "map, for papers"),
    offer(PictureKind::Map, Format::Png, "map, in pixels"),
    offer(PictureKind::Plot, Format::Svg, "plot, for papers"),
    offer(PictureKind::Plot, Format::Png, "plot, in pixels"),
    offer(
        PictureKind::Both,
        Format::Svg,
        "figure of map and plot, for papers",
    ),
    offer(
        PictureKind::Both,
        Format::Png,
        "figure of map and plot, in pixels",
    ),
    offer(PictureKind::Screen, Format::Svg, "whole screen, for papers"),
    offer(PictureKind::Screen, Format::Png, "whole screen, in pixels"),
    offer(
        PictureKind::Animation,
        Format::Gif,
        "map at every step, animated",
    ),
    offer(
        PictureKind::Question,
        Format::Png,
        "picture that models are shown with the question",
    ),
];

/// The pictures that the list shows, the best match first; nothing typed, those of the pane that has the keys, and
/// elsewhere the whole figure.
fn pictures_shown(picker: &Picker, model: &Model) -> Vec<&'static PictureOffer> {
    let first = match model.focus {
        Pane::Plot | Pane::Timeline => PictureKind::Plot,
        Pane::Map => PictureKind::Map,
        _ if model.scene().is_none() => PictureKind::Map,
        _ => PictureKind::Both,
    };
    let texts = OFFERS
        .iter()
        .map(|o| format!("{} {}", o.name, o.format.name()));
    let mut shown: Vec<_> = matching(&picker.text, texts)
        .into_iter()
        .map(|i| &OFFERS[i])
        .collect();
    if picker.text.is_empty() {
        shown.sort_by_key(|offer| offer.kind != first);
    }
    shown
}
