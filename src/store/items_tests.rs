//! Tests of batch items and their states.

#![allow(clippy::unwrap_used)]
use super::*;

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
        .extend_batch(id, "{\"more\":1}", &[item("A", 2)], None)
        .unwrap();
    let key = Key::parse(&"b".repeat(64)).unwrap();
    let (waiting, failed) = (ItemState::Waiting, ItemState::Failed);
    store
        .set_item(id, 1, Some(&key), failed, None, Some("cut off"))
        .unwrap();
    store
        .set_truth(id, "{}", &[(3, Some(false), None)])
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
