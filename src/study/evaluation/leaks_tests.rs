//! Tests of what the surface of questions gives away.
#![allow(clippy::unwrap_used)]

use super::{Leak, leaks};
use nearmiss_scene::verdict::Task;
use nearmiss_store::{NewItem, WindowFacts};

fn item(place: i64, dangerous: bool, last: i64) -> NewItem {
    NewItem {
        path: format!("/data/{place}.xml"),
        scenario: place.to_string(),
        scenario_hash: None,
        ego: None,
        task: Task::Safety,
        frame: Some("ego".into()),
        techniques: Some("base".into()),
        model: "lab/a".into(),
        sample: 0,
        lead: Some("1".into()),
        transform: None,
        window: Some((last - 9, last)),
        facts: Some(WindowFacts {
            steps: (last - 9, last),
            critical: Vec::new(),
            obstacles: (place % 3) as u64,
            speed: 8.0,
            nearest: None,
            ttc: None,
            tokens: 900,
            template_hash: String::new(),
        }),
        scene: None,
        key: None,
        collides: Some(dangerous),
        obstacle: None,
        unaskable: None,
        settings: None,
        split: None,
    }
}

fn only(items: &[NewItem]) -> Leak {
    let found = leaks(items);
    let of_lead = found
        .into_iter()
        .find(|leak| leak.lead.as_deref() == Some("1"));
    of_lead.unwrap()
}

#[test]
fn a_late_window_is_a_dangerous_one() {
    let told: Vec<NewItem> = (0..40)
        .map(|at| item(at, at % 2 == 0, 50 + 40 * ((at + 1) % 2)))
        .collect();
    let leak = only(&told);
    assert_eq!((leak.dangerous, leak.safe), (20, 20));
    assert_eq!(leak.auc[0], Some(1.0));
    assert_eq!(
        (leak.auc[1], leak.auc[3], leak.auc[4]),
        (Some(0.5), Some(0.5), Some(0.5))
    );
    assert_eq!(leak.model_auc, Some(1.0), "a regression finds it, too");
}

#[test]
fn matched_windows_say_nothing_and_each_counts_once() {
    let alike = |at: i64| [item(at, true, 50 + at), item(100 + at, false, 50 + at)];
    let mut items: Vec<NewItem> = (0..30).flat_map(alike).collect();
    let again: Vec<NewItem> = items
        .iter()
        .cloned()
        .map(|one| NewItem { sample: 1, ..one })
        .collect();
    items.extend(again);
    let leak = only(&items);
    assert_eq!((leak.dangerous, leak.safe), (30, 30));
    assert_eq!(leak.auc[0], Some(0.5));
    let model = leak.model_auc.unwrap();
    assert!((0.3..0.7).contains(&model), "{model}");
    assert_eq!(leaks(&items).len(), 1, "a single lead is not shown twice");
    let later = NewItem {
        lead: Some("2".into()),
        ..items[0].clone()
    };
    items.push(later);
    let slots: Vec<Option<String>> = leaks(&items).into_iter().map(|leak| leak.lead).collect();
    assert_eq!(slots.len(), 3, "each lead, and all together: {slots:?}");
    assert_eq!(slots[0], None);
}

#[test]
fn one_class_alone_has_no_curve() {
    let leak = only(&[item(0, true, 50), item(1, true, 60)]);
    assert_eq!((leak.auc[0], leak.model_auc), (None, None));
}
