//! Tests of batch items and their states.

#![allow(clippy::unwrap_used)]
use super::*;
use crate::ItemTruth;

pub fn item(scenario: &str, sample: u32) -> NewItem {
    NewItem {
        path: format!("/data/{scenario}.xml"),
        scenario: scenario.into(),
        scenario_hash: Some("0".repeat(64)),
        ego: Some("1".into()),
        task: Task::Collision,
        frame: Some("ego".into()),
        techniques: Some("cp+cot".into()),
        model: "lab/tiny".into(),
        sample,
        lead: None,
        transform: None,
        window: None,
        facts: None,
        scene: None,
        key: Key::parse(&"a".repeat(64)),
        collides: Some(true),
        obstacle: Some(7),
        unaskable: None,
        settings: None,
        split: None,
    }
}

fn told(place: u64, collides: Option<bool>, critical: Option<&[i64]>) -> ItemTruth {
    ItemTruth {
        place,
        collides,
        obstacle: None,
        critical: critical.map(<[i64]>::to_vec),
    }
}

#[test]
fn another_truth_brings_its_own_critical_obstacles() {
    let store = Store::in_memory().unwrap();
    let facts = WindowFacts {
        steps: (3, 9),
        critical: vec![7, 8],
        speed: 2.5,
        ..WindowFacts::default()
    };
    let known = NewItem {
        facts: Some(facts.clone()),
        ..item("A", 0)
    };
    let asked = [known.clone(), NewItem { sample: 1, ..known }, item("B", 0)];
    let id = store.begin_batch("{}", None, &asked).unwrap();
    let truth = [
        told(0, Some(true), Some(&[9])),
        told(1, Some(true), None),
        told(2, Some(true), Some(&[9])),
    ];
    let mut before = store.items(id).unwrap();
    store.set_truth(id, "{}", &truth).unwrap();
    let items = store.items(id).unwrap();
    let critical = |place: usize| {
        items[place]
            .asked
            .facts
            .as_ref()
            .map(|f| f.critical.clone())
    };
    assert_eq!(critical(0), Some(vec![9]));
    assert_eq!(critical(1), Some(vec![7, 8]));
    assert_eq!(critical(2), None);
    let rest = items[0].asked.facts.clone().unwrap();
    assert_eq!((rest.steps, rest.speed), ((3, 9), 2.5));
    // The same as the program has it before it is stored.
    before
        .iter_mut()
        .zip(&truth)
        .for_each(|(item, one)| item.set_truth(one));
    assert_eq!(before, items);
}

#[test]
fn items_come_back_as_they_were_and_say_where_they_stand() {
    let store = Store::in_memory().unwrap();
    let lost = NewItem {
        unaskable: Some("no ego".into()),
        key: None,
        collides: None,
        obstacle: None,
        ..item("B", 0)
    };
    let begun = [item("A", 0), item("A", 1), lost];
    let id = store.begin_batch("{}", Some("1/2"), &begun).unwrap();
    store
        .extend_batch(id, "{\"more\":1}", &[item("A", 2)])
        .unwrap();
    let key = Key::parse(&"b".repeat(64)).unwrap();
    let (waiting, failed) = (ItemState::Waiting, ItemState::Failed);
    store
        .set_item(id, 1, Some(&key), failed, None, Some("cut off"))
        .unwrap();
    store
        .set_truth(id, "{}", &[told(3, Some(false), None)])
        .unwrap();
    let items = store.items(id).unwrap();
    let states: Vec<_> = items.iter().map(|i| (i.place, i.state)).collect();
    let all = [waiting, failed, ItemState::Unaskable, waiting];
    assert!(states.into_iter().eq((0..).zip(all)));
    assert_eq!(items[0].asked, begun[0]);
    assert_eq!(items[2].asked, begun[2]);
    assert_eq!(items[1].asked.key, Some(key));
    assert_eq!(items[1].error.as_deref(), Some("cut off"));
    assert_eq!(
        (items[3].asked.collides, items[3].asked.obstacle),
        (Some(false), None)
    );
    let (batch, progress) = store.batches().unwrap().remove(0);
    assert_eq!((batch.id, batch.shard.as_deref()), (id, Some("1/2")));
    assert_eq!(
        (progress.scenarios, progress.all(), progress.waiting),
        (2, 4, 2)
    );
    assert_eq!(store.last_batch().unwrap().unwrap().id, id);
    assert_eq!(id.to_string().parse(), Ok(id));
    assert!("seven".parse::<BatchId>().is_err() && "b0".parse::<BatchId>().is_err());
}
