//! The rows of the results screen, sorted and exported.

use super::counted::{NO, YES, item, spec};
use super::history_store::Fixture;
use super::results::press;
use nearmiss_store::{ItemState, NewItem};
use nearmiss_study::evaluation::Outcome;

#[test]
fn rows_are_sorted_by_any_column_and_written_where_pictures_go() {
    let folder = tempfile::tempdir().unwrap();
    let mut kept = techniques();
    kept.bench.model.config.pictures = Some(folder.path().into());
    press(&mut kept, "space o r");
    let column = |kept: &Fixture| -> Vec<u32> {
        let rows = kept.bench.model.results.rows.iter();
        rows.map(|row| row.count(Outcome::TruePositive)).collect()
    };
    let by_prompt = column(&kept);
    press(&mut kept, "right s");
    assert!(column(&kept).is_sorted_by(|a, b| a >= b));
    assert!(kept.bench.frame(120, 40).contains("▼=tp"));
    press(&mut kept, "s");
    assert!(column(&kept).is_sorted());
    assert!(kept.bench.frame(120, 40).contains("▲=tp"));
    press(&mut kept, "s");
    assert_eq!(column(&kept), by_prompt);
    press(&mut kept, "e e");
    let said = &kept.bench.model.toasts.last().unwrap().text;
    assert!(said.contains("results_2.csv"), "{said}");
    let table = std::fs::read_to_string(folder.path().join("results.csv")).unwrap();
    assert_eq!(table.lines().count(), 9);
    assert!(table.contains("labels from /labels/ours.csv"), "{table}");
    let lines = std::fs::read_to_string(folder.path().join("results.jsonl")).unwrap();
    let row: serde_json::Value = serde_json::from_str(lines.lines().next().unwrap()).unwrap();
    assert_eq!(row["tp"], by_prompt[0]);
}

/// A batch of two models, each asked with four sets of techniques about twelve scenarios; what they say is up to their
/// places.
pub(super) fn techniques() -> Fixture {
    let mut kept = Fixture::new();
    let mut items = Vec::new();
    for (model, skill) in [("lab/large", 5), ("lab/small", 3)] {
        for (place, words) in ["base", "cp", "cp+cot", "cp+cot+icl"]
            .into_iter()
            .enumerate()
        {
            for n in 0..12 {
                let right = (n * 7 + place * 3) % 8 < skill + place / 2;
                let text = if (n % 2 == 0) == right { YES } else { NO };
                let run = kept.add(&format!("ZAM_Town-{n}_1_T-1"), model, text == YES, text);
                let asked = NewItem {
                    techniques: Some(words.into()),
                    model: model.into(),
                    ..item(&format!("ZAM_Town-{n}_1_T-1"), (n % 2 == 0, None), None)
                };
                items.push((asked, run));
            }
        }
    }
    let asked: Vec<NewItem> = items.iter().map(|(item, _)| item.clone()).collect();
    let (store, state) = (&kept.store, ItemState::Answered);
    let batch = store.begin_batch(&spec().to_json(), None, &asked).unwrap();
    for (place, (_, run)) in (0..).zip(items) {
        let set = store.set_item(batch, place, None, state, Some(run), None);
        set.unwrap();
    }
    kept
}
