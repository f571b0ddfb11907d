//! The tables of a batch with a split: one for each part; of a locked test split its progress alone.

use super::running::Table;
use super::table::BatchTable;
use crate::{Failure, Outcome, output};
use nearmiss_store::{BatchId, SplitPart, Store};
use nearmiss_study::evaluation::batch::{TestSplit, answers_of_part};

/// Writes them.
pub fn show(store: &Store, id: BatchId, test: &TestSplit, table: Table) -> Outcome {
    let of_part = |part: &SplitPart| {
        let answers = answers_of_part(store, id, Some(*part)).map_err(Failure::input)?;
        Ok((*part, BatchTable::new(Some(*part), &answers)))
    };
    let shown = test
        .visible_parts()
        .iter()
        .map(of_part)
        .collect::<Result<Vec<_>, Failure>>()?;
    let dev = store
        .split_progress(id, SplitPart::Dev)
        .map_err(Failure::input)?;
    let looks = test.looks_note();
    let tables = |shown: Vec<(SplitPart, BatchTable)>| -> Vec<BatchTable> {
        shown.into_iter().map(|(_, table)| table).collect()
    };
    if table.json {
        let splits = test.parts(dev).to_vec();
        output::document(&BatchTable::document(Some(id), tables(shown), splits))?;
    } else if table.csv {
        BatchTable::write_csv(id, &tables(shown))?;
    } else {
        let mut text = format!(
            "dev split: {} of {} answered\n",
            dev.answered, dev.questions
        );
        for (part, table) in &shown {
            if *part == SplitPart::Test {
                text += &format!("\n{}\n", test.summary());
            }
            text += &table.text()?;
        }
        if test.is_locked() {
            text += &format!("\n{}\n", test.summary());
        }
        text.extend(looks.iter().map(|words| format!("{words}\n")));
        return output::text(&text);
    }
    // Programs have it in their data.
    output::say(&format!("nearmiss: {}", test.summary()));
    if let Some(words) = looks {
        output::say(&format!("nearmiss: {words}"));
    }
    Ok(())
}
