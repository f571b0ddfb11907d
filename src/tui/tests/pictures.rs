//! Saving pictures: choices, file names and messages.

use crate::features::generation::request::Generate;
use crate::features::pictures::{SavePicture, save};
use crate::loaded::{PictureJob, PictureKind};
use crate::message::{Effect, Msg};
use crate::model::Pane;
use crate::pixels::Encoder;
use crate::services::Drawing;
use crate::tests::bench::{self, Bench, generated_variant};
use nearmiss_render::MapExtent;

fn asked(bench: &mut Bench) -> Box<PictureJob> {
    match bench.effects.pop() {
        Some(Effect::Picture(job)) => job,
        other => panic!("no picture was asked for: {other:?}"),
    }
}

#[test]
fn o_offers_what_has_the_keys_first() {
    let mut bench = Bench::bundled();
    for (pane, kind) in [
        (Pane::Map, PictureKind::Map),
        (Pane::Plot, PictureKind::Plot),
        (Pane::Scenarios, PictureKind::Both),
    ] {
        bench.model.focus = pane;
        bench.press("space o p enter");
        assert_eq!(asked(&mut bench).kind, kind);
    }
}

#[test]
fn a_picture_is_of_what_is_seen_now() {
    let mut bench = Bench::bundled();
    bench.frame(200, 60);
    bench.press("x");
    bench.model.focus = Pane::Map;
    bench.model.camera.cell = 0.5;
    bench.model.camera.auto = false;
    bench.press("space o p");
    bench.type_text("animated");
    bench.press("enter");
    let job = asked(&mut bench);
    assert_eq!(job.kind, PictureKind::Animation);
    assert_eq!(job.step, bench.model.clock.step());
    assert_eq!(job.look.obstacles, [301]);
    let (columns, _) = bench.model.drawn.map_size();
    let width = 0.5 * f64::from(columns);
    assert_eq!(job.look.seen, MapExtent::Ego { width });
    assert!(!job.needs_screen());
}

#[test]
fn where_it_is_or_why_not_is_said() {
    let mut bench = Bench::bundled();
    bench.send(Msg::reply::<SavePicture>(Ok("a/b.svg".into())));
    assert!(bench.frame(120, 40).contains("saved as a/b.svg"));
    bench.send(Msg::reply::<SavePicture>(Err("no space".into())));
    assert!(bench.frame(120, 40).contains("no picture: no space"));
}

#[test]
fn the_picture_of_the_question_is_saved_as_models_are_sent_it() {
    let mut bench = Bench::bundled();
    bench.frame(120, 40);
    let wish = |bench: &mut Bench| {
        bench.press("space o p");
        bench.type_text("models are shown");
        bench.press("enter");
    };
    wish(&mut bench);
    let saves = |effect: &Effect| matches!(effect, Effect::Picture(_));
    assert!(!bench.effects.iter().any(saves), "the ego frame has none");
    assert!(
        bench
            .frame(120, 40)
            .contains("this question has no picture")
    );
    bench.model.frame = nearmiss_scene::description::Frame::Picture;
    bench.model.refresh();
    wish(&mut bench);
    let mut job = asked(&mut bench);
    let folder = tempfile::tempdir().unwrap();
    job.folder = Some(folder.path().into());
    let path = save(&job, &Drawing::default().begin()).unwrap();
    assert!(path.ends_with("_question.png"), "{path}");
    let question = bench.model.prompt.question.as_ref().unwrap();
    let sent = question.messages()[1].images[0].clone();
    assert_eq!(std::fs::read(path).unwrap(), &sent.bytes[..]);
}

#[test]
fn where_the_terminal_shows_images_the_picture_for_models_stands_beside_the_answer() {
    let mut bench = Bench::bundled();
    bench.model.map.images.encoder = Some(Encoder::kitty((10, 20), false));
    bench.model.frame = nearmiss_scene::description::Frame::EgoPicture;
    bench.model.refresh();
    let mut drawn = |shown: bool| {
        bench.model.map.layers.shown = shown;
        bench.frame(200, 60);
        bench.model.drawn.take_picture().unwrap()
    };
    let (map, shown) = (drawn(false), drawn(true));
    assert_eq!(map.cells, shown.cells);
    assert_ne!(map.picture.items, shown.picture.items);
    let question = bench.model.prompt.question.as_ref().unwrap();
    let whole = question.picture.as_ref().unwrap().picture();
    assert_eq!(shown.picture.items, whole.items);
    // As large as it fits, and the page fills the pane.
    let pixels = |points: f64| (points * shown.dpi / 72.0).round();
    let (columns, rows) = shown.cells;
    assert_eq!(pixels(shown.picture.size.0), f64::from(columns) * 10.0);
    assert_eq!(pixels(shown.picture.size.1), f64::from(rows) * 20.0);
    assert!(shown.picture.size.0 >= whole.size.0 - 1e-9);
    assert!(shown.picture.size.1 >= whole.size.1 - 1e-9);
}

#[test]
fn without_a_scenario_there_is_nothing_to_draw() {
    let mut bench = Bench::empty();
    bench.press("space o p");
    assert!(bench.model.screens.is_empty());
}

#[test]
fn a_variant_is_drawn_with_both_motions_of_its_attacker() {
    let mut bench = Bench::bundled();
    bench.press("/");
    bench.type_text("rightturn");
    bench.press("enter space g g");
    let Ok(Generate { id, request }) = bench.effects.pop().unwrap().into_request() else {
        panic!("nothing was searched for");
    };
    bench.send(bench::generated(id, generated_variant(&request)));
    bench.frame(200, 60);
    bench.model.focus = Pane::Map;
    let folder = tempfile::tempdir().unwrap();
    bench.model.config.pictures = Some(folder.path().into());
    let drawn = |bench: &mut Bench| {
        bench.press("space o p");
        bench.type_text("svg");
        bench.press("enter");
        let job = asked(bench);
        assert_eq!(job.kind, PictureKind::Map);
        let path = save(&job, &Drawing::default().begin()).unwrap();
        std::fs::read_to_string(path).unwrap()
    };
    let attacker = bench.model.variant().unwrap().made.effect.main().obstacle;
    let [recorded, changed] = ["recorded", "changed"].map(|word| format!("{attacker} {word}"));
    let svg = drawn(&mut bench);
    assert!(svg.contains(&recorded) && !svg.contains(&changed), "{svg}");
    assert!(svg.contains("as recorded and as changed"));
    bench.press("space g o");
    let svg = drawn(&mut bench);
    assert!(svg.contains(&changed) && !svg.contains(&recorded), "{svg}");
    bench.model.map.layers.variant = false;
    let svg = drawn(&mut bench);
    assert!(
        !svg.contains(&changed) && !svg.contains("variation"),
        "{svg}"
    );
}
