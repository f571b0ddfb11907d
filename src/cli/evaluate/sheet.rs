//! What a batch would ask: its questions, and what they take, before anything is sent.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;
use serde_json::json;

use super::truth::say_each;
use crate::cli::progress::Progress;
use crate::cli::{Failure, Outcome, output};
use crate::evaluation::Question;
use crate::evaluation::batch::{Ask, Desk, Estimate, Judges, Truth};
use crate::scenario::Entry;
use crate::store::{NewItem, Store};

/// The questions of a batch.
pub struct Sheet {
    /// In the order in which they are asked.
    pub items: Vec<NewItem>,
    /// What they take.
    pub estimate: Estimate,
    /// For each model a question that would be sent to it.
    pub first: BTreeMap<String, Arc<Question>>,
    unlabelled: Vec<String>,
    doubts: Vec<String>,
}

impl Sheet {
    /// Makes the questions about these entries, on all cores.
    pub fn of(
        wanted: &[(Entry, Vec<Ask>)],
        desk: &Desk,
        truth: &Truth,
        judges: &Judges,
        store: &Store,
    ) -> Result<Self, Failure> {
        let mut sheet = Self {
            items: Vec::new(),
            estimate: Estimate::default(),
            first: BTreeMap::new(),
            unlabelled: Vec::new(),
            doubts: Vec::new(),
        };
        let progress = Progress::new(wanted.len(), "scenarios described", true);
        // A part at a time keeps all cores busy and the memory bounded.
        for part in wanted.chunks(64) {
            let looked: Vec<_> = part
                .par_iter()
                .map(|(entry, asks)| {
                    let looked = desk.look(entry, asks, truth, judges, Some(store));
                    progress.step();
                    looked
                })
                .collect();
            for ((entry, _), looked) in part.iter().zip(looked) {
                let looked = looked.map_err(Failure::input)?;
                if let Some(wrong) = looked.wrong {
                    return Err(Failure::input(format!("--truth: {wrong}")));
                }
                if looked.unlabelled {
                    sheet.unlabelled.push(entry.name.clone());
                }
                let doubts = looked.doubts.iter().map(|d| format!("{}: {d}", entry.name));
                sheet.doubts.extend(doubts);
                for (model, question) in looked.first {
                    sheet.first.entry(model).or_insert(question);
                }
                for (item, size) in looked.items {
                    sheet.estimate.add(size, item.unaskable.as_deref());
                    sheet.items.push(item);
                }
            }
        }
        Ok(sheet)
    }

    /// Says what is doubtful, and which scenarios are left out.
    pub fn say_doubts(&self) {
        say_each(&self.doubts);
        if !self.unlabelled.is_empty() {
            output::say(&format!(
                "nearmiss: left out, as nobody says what is true about them: {}",
                super::some(&self.unlabelled)
            ));
        }
    }

    /// The same as [`Sheet::write`] in one line.
    pub fn line(&self) -> String {
        let estimate = &self.estimate;
        let mut words = format!(
            "{}, about {} tokens, {}",
            super::number(count(estimate.requests), "request"),
            estimate.tokens,
            estimate.price()
        );
        if estimate.free > 0 {
            words.push_str(&format!("; {} for the built-in judge", estimate.free));
        }
        if estimate.stored > 0 {
            let stored = super::number(count(estimate.stored), "answer");
            let are = if estimate.stored == 1 { "is" } else { "are" };
            words.push_str(&format!("; {stored} {are} in the store"));
        }
        if estimate.unaskable > 0 {
            let why = estimate.why.first().map_or("", |(why, _)| why.as_str());
            words.push_str(&format!("; {} cannot be asked: {why}", estimate.unaskable));
        }
        words
    }

    /// Writes what would be asked; `refused` is why models cannot be asked as things stand.
    /// `budget` is the most that the run may cost, US dollars.
    pub fn write(&self, refused: &[(String, String)], budget: Option<f64>, json: bool) -> Outcome {
        let estimate = &self.estimate;
        let budget = budget.map(|usd| (usd, within(estimate, usd)));
        if json {
            let unaskable = estimate.why.iter();
            let unaskable = unaskable.map(|(why, count)| json!({ "why": why, "questions": count }));
            let refused = refused.iter();
            let refused = refused.map(|(model, why)| json!({ "model": model, "why": why }));
            return output::json(&json!({
                "questions": self.items.len(),
                "requests": estimate.requests,
                "built_in": estimate.free,
                "stored": estimate.stored,
                "unaskable": estimate.unaskable,
                "why": unaskable.collect::<Vec<_>>(),
                "left_out": self.unlabelled,
                "tokens": estimate.tokens,
                "usd": estimate.usd,
                "budget": budget.map(|(usd, _)| usd),
                "within_budget": budget.and_then(|(_, within)| within),
                "unbounded": estimate.unbounded,
                "unpriced": estimate.unpriced,
                "refused": refused.collect::<Vec<_>>(),
            }));
        }
        let mut text = format!(
            "questions        {}\nrequests         {}\nbuilt-in judge   {}\nin the store     {}\ncannot be asked  {}\n",
            self.items.len(),
            estimate.requests,
            estimate.free,
            estimate.stored,
            estimate.unaskable
        );
        for (why, count) in &estimate.why {
            text.push_str(&format!("  {count} × {why}\n"));
        }
        text.push_str(&format!(
            "tokens           {} (estimated, without the answers)\nprice            {}\n",
            estimate.tokens,
            estimate.price()
        ));
        if let Some((usd, within)) = budget {
            let words = match within {
                Some(true) => "enough for all",
                Some(false) => {
                    "less than that: questions that could cost more than what is left stay open, for --resume"
                }
                None => "whether it is enough for all cannot be told",
            };
            text.push_str(&format!("budget           {usd} USD, {words}\n"));
        }
        for (model, why) in refused {
            text.push_str(&format!("refused          {model}: {why}\n"));
        }
        output::text(&output::visible(&text))
    }
}

/// Whether a budget is enough for everything; nothing where that cost is unknown.
fn within(estimate: &Estimate, usd: f64) -> Option<bool> {
    let known = estimate.unbounded == 0 && estimate.unpriced == 0;
    match estimate.usd > usd {
        true => Some(false),
        false => known.then_some(true),
    }
}

fn count(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}
