//! The tables of a batch with a split: one for each part; of a locked test split its progress alone.

use super::running::Table;
use super::table::Rows;
use super::varied::Varied;
use crate::{Failure, Outcome, output};
use nearmiss_store::{BatchId, SplitPart, Store};
use nearmiss_study::evaluation::batch::{TestSplit, answers_of_part};
use nearmiss_study::evaluation::report::joined;

/// Writes them.
pub fn show(store: &Store, id: BatchId, test: &TestSplit, table: Table) -> Outcome {
    let of_part = |part: &SplitPart| {
        let answers = answers_of_part(store, id, Some(*part)).map_err(Failure::input)?;
        let rows = Rows::from_scored(&answers.plain);
        Ok((*part, rows, Varied::from_answers(&answers)))
    };
    let shown = test
        .shown()
        .iter()
        .map(of_part)
        .collect::<Result<Vec<_>, Failure>>()?;
    let dev = store
        .split_progress(id, SplitPart::Dev)
        .map_err(Failure::input)?;
    let looks = test.looks_words();
    if table.json {
        let documents = shown.iter().map(|(part, rows, varied)| {
            let mut document = rows.document(Some(id));
            varied.add_to(&mut document);
            (*part, document)
        });
        let documents: Vec<_> = documents.collect();
        output::json(&joined(&documents, &test.parts(dev)))?;
    } else if table.csv {
        let rows = shown.iter().map(|(part, rows, _)| (Some(*part), rows));
        Rows::write_csv(&rows.collect::<Vec<_>>())?;
    } else {
        let mut text = format!(
            "dev split: {} of {} answered\n",
            dev.answered, dev.questions
        );
        for (part, rows, varied) in &shown {
            if *part == SplitPart::Test {
                text += &format!("\n{}\n", test.words());
            }
            text += &(rows.table() + &varied.tables());
        }
        if test.is_locked() {
            text += &format!("\n{}\n", test.words());
        }
        text.extend(looks.iter().map(|words| format!("{words}\n")));
        return output::text(&text);
    }
    // Programs have it in their data.
    output::say(&format!("nearmiss: {}", test.words()));
    if let Some(words) = looks {
        output::say(&format!("nearmiss: {words}"));
    }
    Ok(())
}
