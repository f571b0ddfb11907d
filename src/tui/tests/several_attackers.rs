//! Variants with several attackers: made, told and drawn.

use super::bench::Bench;
use super::making::{arrive, asked, made, open, said};
use crate::features::pictures::save;
use crate::message::Effect;
use crate::services::Drawing;

/// A scenario in which one obstacle alone reaches nothing with so few motions, and two do.
const SCENARIO: &str = "hardbraking";
const SEED: u64 = 9;

fn attacked_by_two() -> Bench {
    let mut bench = open(SCENARIO);
    bench.model.config.attackers = Some(2);
    let hash = bench.model.opened.as_ref().unwrap().scenario.hash;
    for _ in 1..SEED {
        bench.model.maker.next_seed(hash, None);
    }
    bench.press("space g g");
    assert!(said(&bench).contains("one obstacle or several"));
    let wish = asked(&bench).pop().unwrap().1;
    assert_eq!((wish.attackers, wish.seed), (2, SEED));
    arrive(&mut bench);
    assert_eq!(made(&bench).effect.attackers.len(), 2, "{}", said(&bench));
    bench
}

#[test]
fn the_panel_tells_what_each_does_and_what_comes_without_it() {
    let mut bench = attacked_by_two();
    let ids: Vec<i64> = made(&bench).effect.ids().collect();
    assert!(said(&bench).contains(&format!("{} and {} given new motions", ids[0], ids[1])));
    bench.press("space g v");
    let panel = bench.frame(200, 120);
    assert!(panel.contains("attackers"), "{panel}");
    for id in ids {
        assert!(panel.contains(&format!("{id} at ")), "{panel}");
    }
    let all = &made(&bench).effect.attackers;
    assert!(all.iter().all(|one| one.without.is_some()));
    assert_eq!(panel.matches("up to step").count(), 2, "{panel}");
}

#[test]
fn the_map_and_pictures_draw_the_motions_of_both() {
    let mut bench = attacked_by_two();
    let ids: Vec<i64> = made(&bench).effect.ids().collect();
    bench
        .model
        .clock
        .go(made(&bench).change.until_step().unwrap());
    bench.frame(200, 60);
    let folder = tempfile::tempdir().unwrap();
    bench.model.config.pictures = Some(folder.path().into());
    bench.press("space o p");
    bench.type_text("svg");
    bench.press("enter");
    let Some(Effect::Picture(job)) = bench.effects.pop() else {
        panic!("no picture was asked for");
    };
    let path = save(&job, &Drawing::default().begin()).unwrap();
    let svg = std::fs::read_to_string(path).unwrap();
    for id in ids {
        assert!(svg.contains(&format!("obstacle {id} after step ")), "{svg}");
    }
}
