//! The pictures that can be saved.

use super::picker::matching;
use super::{Pane, Picker};
use crate::picture::Format;
use crate::tui::loaded::PictureKind;

/// A picture that can be chosen.
#[derive(Debug)]
pub struct PictureOffer {
    /// What it shows.
    pub kind: PictureKind,
    /// How it is written.
    pub format: Format,
    /// What it is called.
    pub name: &'static str,
}

const fn offer(kind: PictureKind, format: Format, name: &'static str) -> PictureOffer {
    PictureOffer { kind, format, name }
}

const OFFERS: &[PictureOffer] = &[
    offer(PictureKind::Map, Format::Svg, "map, for papers"),
    offer(PictureKind::Map, Format::Png, "map, in pixels"),
    offer(PictureKind::Plot, Format::Svg, "plot, for papers"),
    offer(PictureKind::Plot, Format::Png, "plot, in pixels"),
    offer(PictureKind::Both, Format::Svg, "map and plot, for papers"),
    offer(PictureKind::Both, Format::Png, "map and plot, in pixels"),
    offer(PictureKind::Screen, Format::Svg, "whole screen, for papers"),
    offer(PictureKind::Screen, Format::Png, "whole screen, in pixels"),
    offer(
        PictureKind::Animation,
        Format::Gif,
        "map at every step, animated",
    ),
];

/// The pictures that the list shows, the best match first; nothing typed, those of the pane that has the keys.
#[must_use]
pub fn pictures_shown(picker: &Picker, focus: Pane) -> Vec<&'static PictureOffer> {
    let first = match focus {
        Pane::Plot | Pane::Timeline => PictureKind::Plot,
        Pane::Map => PictureKind::Map,
        _ => PictureKind::Screen,
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
