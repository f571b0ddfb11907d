//! The map as an image: what it is to show, and whether it can be shown.

use ratatui::layout::Rect;

use super::{CellView, MapScene, request as scene_request, with_layers};
use crate::model::{MapChoice, MapPicture, Model, Moment};
use crate::pixels::{Encoder, MapImage};
use crate::theme::components;
use nearmiss_render::{MapPage, Palette, Picture};
use nearmiss_settings::ThemeColor;

/// How images are sent, where the map is to be one and nothing lies over it. What covers an image would leave marks at
/// terminals that paint it once; there, and below windows, the map is drawn in cells.
pub fn encoder(model: &Model) -> Option<&Encoder> {
    let chosen = matches!(model.look.map, MapChoice::Auto | MapChoice::Pixels);
    let encoder = model.map.images.encoder.as_ref()?;
    let covered = !model.screens.is_empty()
        || !model.look.pending.is_empty()
        || !encoder.can_be_covered() && !model.toasts.is_empty();
    (chosen && !covered && !model.drawn.is_for_picture()).then_some(encoder)
}

/// Draws the picture that the image is to show.
pub fn request(model: &Model, moment: &Moment<'_>, encoder: &Encoder, area: Rect, view: &CellView) {
    let (width, height) = encoder.cell();
    if model.map.layers.shown
        && let Some(picture) = for_models(model)
    {
        let pixels = (
            width * u32::from(area.width),
            height * u32::from(area.height),
        );
        let (picture, dpi) = filling(picture, pixels);
        model.drawn.set_picture(MapPicture {
            picture,
            dpi,
            cells: (area.width, area.height),
        });
        return;
    }
    let part = encoder.coarseness(model.clock.playing);
    let page = MapPage {
        pixels: (
            (width * u32::from(area.width)).div_ceil(part),
            (height * u32::from(area.height)).div_ceil(part),
        ),
        line: f64::from(height) / f64::from(part),
        frame: view.frame,
        width: 2.0 * view.half.0,
    };
    let request = scene_request(model, moment, page.viewport());
    let scene = with_layers(MapScene::new(&request), model, moment);
    let picture = page.draw(&request, scene, &palette(model));
    model.drawn.set_picture(MapPicture {
        picture,
        dpi: page.dpi(),
        cells: (area.width, area.height),
    });
}

/// The picture that models are shown with the present question, if its frame has one.
fn for_models(model: &Model) -> Option<Picture> {
    let question = model.prompt.question.as_ref()?;
    Some(question.picture.as_ref()?.picture())
}

/// A picture on a page of so many pixels, as large as it fits there, and its resolution.
fn filling(mut picture: Picture, (width, height): (u32, u32)) -> (Picture, f64) {
    let (width, height) = (f64::from(width), f64::from(height));
    let scale = (width / picture.size.0).min(height / picture.size.1);
    picture.size = (width / scale, height / scale);
    (picture, 72.0 * scale)
}

/// The image, where it fills the area.
pub fn shown(model: &Model, area: Rect) -> Option<&MapImage> {
    let shown = model.map.images.shown.as_ref();
    shown.filter(|image| image.fits(area))
}

/// The theme's colours; those that only the terminal knows are those of pictures.
fn palette(model: &Model) -> Palette {
    let theme = model.theme.0.clone().map(|color| match components(color) {
        Some([red, green, blue]) => ThemeColor::Rgb(red, green, blue),
        None => ThemeColor::Terminal,
    });
    Palette::themed(&theme)
}
