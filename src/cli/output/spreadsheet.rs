//! CSV for spreadsheets, which take text that begins like a formula for one.

use crate::{Failure, Outcome};

/// The option for it, on the command line.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ForSpreadsheet {
    /// For CSV that a spreadsheet opens: put an apostrophe before text that it would run as a formula.
    #[arg(long)]
    for_spreadsheet: bool,
}

impl ForSpreadsheet {
    /// Refuses it for other formats, and where nothing is written.
    pub fn check(self, is_csv: bool) -> Outcome {
        if self.for_spreadsheet && !is_csv {
            Err(Failure::input(
                "--for-spreadsheet is for CSV alone; choose it as the format",
            ))
        } else {
            Ok(())
        }
    }

    /// Whether it was asked for.
    pub fn is_asked(self) -> bool {
        self.for_spreadsheet
    }

    /// CSV as it was asked for.
    pub fn applied(self, csv: Vec<u8>) -> Vec<u8> {
        if self.for_spreadsheet {
            without_formulas(&csv)
        } else {
            csv
        }
    }
}

/// The same CSV, whose cells are no formulas.
fn without_formulas(csv: &[u8]) -> Vec<u8> {
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader.has_headers(false).flexible(true).from_reader(csv);
    let mut writer = csv::WriterBuilder::new()
        .flexible(true)
        .from_writer(Vec::new());
    for record in reader.into_byte_records().flatten() {
        let cells = record.iter().map(|cell| {
            if std::str::from_utf8(cell).is_ok_and(nearmiss_record::begins_formula) {
                [b"'", cell].concat()
            } else {
                cell.to_vec()
            }
        });
        // Writing to memory does not fail.
        let _ = writer.write_record(cells);
    }
    writer.into_inner().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_are_text_and_numbers_stay() {
        let csv = "name,value,said\n=1+1,-3.5,\"=HYPERLINK(\"\"http://x\"\",\"\"a\"\")\"\n\
                   @SUM,+2e3,\"a, -b\"\n-,inf,-inf\n\"-a\nb\",,'=x\n";
        let wanted = "name,value,said\n'=1+1,-3.5,\"'=HYPERLINK(\"\"http://x\"\",\"\"a\"\")\"\n\
                      '@SUM,+2e3,\"a, -b\"\n'-,inf,-inf\n\"'-a\nb\",,'=x\n";
        let asked = |for_spreadsheet| ForSpreadsheet { for_spreadsheet };
        assert_eq!(asked(true).applied(csv.into()), wanted.as_bytes());
        assert_eq!(asked(false).applied(csv.into()), csv.as_bytes());
        assert!(asked(true).check(false).is_err() && asked(false).check(false).is_ok());
    }
}
