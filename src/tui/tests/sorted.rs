//! The rows of the results screen, sorted and exported.

use super::counted::techniques;
use super::kept::Fixture;
use super::results::press;
use crate::evaluation::Outcome;

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
    assert!(kept.bench.frame(120, 40).contains("▼tp"));
    press(&mut kept, "s");
    assert!(column(&kept).is_sorted());
    assert!(kept.bench.frame(120, 40).contains("▲tp"));
    press(&mut kept, "s");
    assert_eq!(column(&kept), by_prompt);
    press(&mut kept, "e e");
    let said = &kept.bench.model.toasts.last().unwrap().text;
    assert!(said.contains("results_2.csv"), "{said}");
    let table = std::fs::read_to_string(folder.path().join("results.csv")).unwrap();
    assert_eq!(table.lines().count(), 9);
    assert!(table.contains("labels of /labels/ours.csv"), "{table}");
    let lines = std::fs::read_to_string(folder.path().join("results.jsonl")).unwrap();
    let row: serde_json::Value = serde_json::from_str(lines.lines().next().unwrap()).unwrap();
    assert_eq!(row["tp"], by_prompt[0]);
}
