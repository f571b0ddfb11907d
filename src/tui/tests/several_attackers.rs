//! Variants with several attackers.

use super::variant_fixtures::generated;
use crate::formats::{Entry, bundled};
use crate::planner::Forecast;
use crate::tui::loaded::{GenerationOutcome, VariantRequest};

#[test]
fn probe() {
    for entry in bundled() {
        for seed in 1..=3 {
            let wish = VariantRequest {
                entry: entry.clone(),
                change: None,
                forecast: Forecast::Lane,
                only: None,
                attackers: 2,
                seed,
                writer: None,
                style: Default::default(),
                folder: None,
            };
            let made = generated(&wish);
            let words = match made {
                Ok(GenerationOutcome::Found { variant, .. }) => {
                    let made = &variant.variant.as_ref().unwrap().made;
                    format!(
                        "{:?} {:?}",
                        made.effect.ids().collect::<Vec<_>>(),
                        made.effect.consequence.name()
                    )
                }
                Ok(_) => "nothing".into(),
                Err(why) => why,
            };
            println!("PROBE {} {seed}: {words}", entry.name);
        }
    }
}

fn _unused(_: Entry) {}
