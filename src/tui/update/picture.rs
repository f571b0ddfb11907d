//! Saving pictures of what is shown.

use super::super::loaded::{PictureJob, PictureKind};
use super::super::message::Effect;
use super::super::model::{Model, Overlay, Picker, pictures_shown};
use crate::picture::{Look, Seen, What};

/// Opens the list of pictures.
pub fn choose(model: &mut Model) {
    if model.opened.is_none() {
        return model.say("no scenario is open");
    }
    model.overlays.push(Overlay::Pictures(Picker::default()));
}

/// Asks for the selected picture.
pub fn chosen(model: &mut Model, picker: &Picker) -> Vec<Effect> {
    let shown = pictures_shown(picker, model.focus);
    let (Some(offer), Some(opened)) = (shown.get(picker.selected), &model.opened) else {
        return Vec::new();
    };
    let kind = offer.kind;
    if matches!(kind, PictureKind::Plot | PictureKind::Both) && opened.scene.is_none() {
        let why = model.without_ego();
        model.say(format!("nothing to plot: {why}"));
        return Vec::new();
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
    };
    if kind == PictureKind::Animation {
        model.say("the animation is being drawn");
    }
    vec![Effect::Picture(Box::new(job))]
}

/// As the map and the plot are seen now, in the colours of a paper.
fn look(model: &Model, kind: PictureKind) -> Look {
    let (columns, _) = model.drawn.map_size();
    let width = (model.camera.cell * f64::from(columns)).max(2.0);
    let seen = match model.camera.follow {
        true => Seen::Ego { width },
        false => Seen::Around {
            center: model.camera.center,
            width,
        },
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
    Look {
        what: match kind {
            PictureKind::Plot => What::Plot,
            PictureKind::Both => What::Both,
            _ => What::Map,
        },
        seen,
        ego_up: model.camera.ego_up,
        obstacles,
        measures: vec![model.plot.measure],
        ..Look::default()
    }
}

/// Says where a picture is, or why there is none.
pub fn saved(model: &mut Model, saved: Result<String, String>) {
    match saved {
        Ok(path) => model.say(format!("saved as {path}")),
        Err(error) => model.complain(format!("no picture: {error}")),
    }
}
