//! Going on with a batch: what is not answered yet, what failed, more models, techniques and samples, another truth.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::Path;

use super::asked::{self, BatchRun};
use super::batch::{Resumed, json, leads_fit};
use super::opened::Opened;
use super::sheet::Sheet;
use super::truth::{say_each, truth_source};
use super::{Evaluate, Format, number, some};
use crate::cli::{Failure, Outcome, output};
use crate::evaluation::batch::{
    Ask, Matrix, Relabelled, Selection, Spec, Truth, TruthSource, Variant, retold,
};
use crate::evaluation::{Lead, Way, batch};
use crate::scenario::Entry;
use crate::store::{Batch, Identity, Item, NewItem};
use crate::verdict::Task;

/// Goes on with a batch.
pub fn run(arguments: &Evaluate, which: Resumed) -> Outcome {
    let options = &arguments.batch;
    let opened = Opened::new()?;
    let batch = chosen(&opened, which)?;
    let mut spec = Spec::from_json(&batch.spec).map_err(Failure::input)?;
    let still = spec.still(&opened.library, &opened.thresholds);
    still.map_err(|why| Failure::input(format!("{}: {why}", batch.id)))?;
    let mut items = opened.store.items(batch.id).map_err(Failure::input)?;
    if let Some(samples) = options.samples.filter(|n| *n < spec.matrix.samples) {
        return Err(Failure::input(format!(
            "--samples {samples}: {} has {} already, and they are not taken away",
            batch.id, spec.matrix.samples
        )));
    }
    let mut spec_before = spec.clone();
    let more = options.more();
    if !more.leads.is_empty() {
        leads_fit(&spec.matrix.tasks, "--add-lead")?;
    }
    spec.matrix.extend(&more);
    let first_lead = newly_named(&spec_before.matrix, &spec.matrix);
    for item in items
        .iter_mut()
        .filter(|item| item.asked.task == Task::Safety)
    {
        item.asked.lead = item.asked.lead.take().or_else(|| first_lead.clone());
    }
    spec.templates
        .extend(Spec::templates_of(&spec.matrix, &opened.library));
    let desk = opened.desk(&spec.matrix);
    let mut missing = Vec::new();
    if let Some(source) = truth_source(&arguments.truth)? {
        let entries: Vec<Entry> = paths(&items).into_iter().map(entry).collect();
        let (truth, doubts) = Truth::open(&source, &entries).map_err(Failure::input)?;
        say_each(&doubts);
        let labels = retold(&items, &truth, &desk);
        let labels = labels.map_err(|wrong| Failure::input(format!("--truth: {wrong}")))?;
        if labels.iter().all(|(_, collides, _)| collides.is_none()) {
            return Err(Failure::input(format!(
                "--truth: it says nothing about any scenario of {}; its truth stays as it was",
                batch.id
            )));
        }
        missing = unlabelled(&items, &labels);
        if source != spec.truth {
            let (before, now) = (spec.truth.words(), source.words());
            let would = if options.dry_run {
                "would be"
            } else {
                "is from now on"
            };
            output::say(&output::visible(&format!(
                "nearmiss: {}: the truth {would}: {now}; it was: {before}",
                batch.id
            )));
        }
        if !missing.is_empty() {
            output::say(&output::visible(&format!(
                "nearmiss: {}: it says nothing about {}: {}; their answers are neither right nor wrong",
                batch.id,
                number(missing.len(), "scenario"),
                some(&missing)
            )));
        }
        for (item, (_, collides, obstacle)) in items.iter_mut().zip(&labels) {
            (item.asked.collides, item.asked.obstacle) = (*collides, *obstacle);
        }
        spec.truth = source.clone();
        spec_before.truth = source;
        if !options.dry_run {
            let json = spec_before.to_json();
            let set = opened.store.set_truth(batch.id, &json, &labels);
            set.map_err(Failure::input)?;
        }
    }
    let selection = match options.retry_failed {
        true => Selection::Failed,
        false => Selection::Open,
    };
    let extended = more.any();
    let there: HashSet<Identity<'_>> = items.iter().map(|item| item.asked.identity()).collect();
    let wanted = wanted(&items, selection, extended.then_some(&spec), &there)?;
    let models: HashSet<&String> = wanted
        .iter()
        .flat_map(|(_, asks)| asks.iter().map(|ask| &ask.way.model))
        .collect();
    let models: Vec<String> = models.into_iter().cloned().collect();
    let judges = opened.judges(&models, &spec, options)?;
    let truth = match spec.truth {
        // Of files that could not be read before.
        TruthSource::Geometry => Truth::Geometry,
        TruthSource::Layout | TruthSource::Files(_) => Truth::known(&items),
    };
    let sheet = Sheet::of(&wanted, &desk, &truth, &judges, &opened.store)?;
    sheet.say_doubts();
    let runtime = asked::runtime()?;
    let refused = asked::refused(&runtime, &sheet, &judges);
    if options.dry_run {
        return sheet.write(&refused, opened.budget(options), json(arguments));
    }
    asked::all_can_be_asked(&refused)?;
    let known = known_now(&items, &sheet.items);
    if !known.is_empty() {
        let set = opened
            .store
            .set_truth(batch.id, &spec_before.to_json(), &known);
        set.map_err(Failure::input)?;
    }
    if extended {
        let new = sheet
            .items
            .iter()
            .filter(|item| !there.contains(&item.identity()));
        let new: Vec<_> = new.cloned().collect();
        let lead = first_lead.as_deref();
        let done = opened
            .store
            .extend_batch(batch.id, &spec.to_json(), &new, lead);
        done.map_err(Failure::input)?;
    }
    let going = BatchRun {
        id: batch.id,
        judges,
        desk,
        selection,
        json: json(arguments),
        csv: arguments.format == Format::Csv,
    };
    if wanted.is_empty() {
        output::say(&format!("nearmiss: {}: there is nothing to ask", batch.id));
        asked::show(&opened, batch.id, going.json, going.csv)?;
    } else {
        asked::ask(&runtime, &opened, options, going, &sheet)?;
    }
    match missing.len() {
        0 => Ok(()),
        count => Err(Failure {
            message: format!("{} without a label", number(count, "scenario")),
            status: 1,
        }),
    }
}

/// The scenarios that another truth says nothing about, by name.
fn unlabelled(items: &[Item], labels: &[Relabelled]) -> Vec<String> {
    let without = items
        .iter()
        .zip(labels)
        .filter(|(_, label)| label.1.is_none());
    let names: BTreeSet<&str> = without
        .map(|(item, _)| item.asked.scenario.as_str())
        .collect();
    names.into_iter().map(String::from).collect()
}

/// The first lead in words, where the questions of a batch do not name it and have to from now on, as there are others.
fn newly_named(before: &Matrix, now: &Matrix) -> Option<String> {
    let lead = now.manner.lead.filter(|_| before.more_leads.is_empty());
    let lead = lead.filter(|_| !now.more_leads.is_empty());
    lead.map(Lead::stored)
}

/// The truth about scenarios that could not be read when the batch was begun, and can be now.
fn known_now(items: &[Item], now: &[NewItem]) -> Vec<(u64, Option<bool>, Option<i64>)> {
    let known = now.iter().filter(|item| item.collides.is_some());
    let known: BTreeMap<&str, &NewItem> = known.map(|item| (item.path.as_str(), item)).collect();
    let unknown = items.iter().filter(|item| item.asked.collides.is_none());
    let found = unknown.filter_map(|item| {
        let now = known.get(item.asked.path.as_str())?;
        Some((item.place, now.collides, now.obstacle))
    });
    found.collect()
}

fn chosen(opened: &Opened, which: Resumed) -> Result<Batch, Failure> {
    let found = match which {
        Resumed::Last => opened.store.last_batch(),
        Resumed::Batch(id) => opened.store.batch(id),
    };
    found.map_err(Failure::input)?.ok_or_else(|| {
        let name = match which {
            Resumed::Last => "there is no batch yet".to_string(),
            Resumed::Batch(id) => format!("there is no batch {id}"),
        };
        Failure::input(format!("{name}; `nearmiss evaluate --list` lists them"))
    })
}

/// The scenarios of a batch, in their order.
fn paths(items: &[Item]) -> Vec<&str> {
    let mut seen = HashSet::new();
    let paths = items.iter().map(|item| item.asked.path.as_str());
    paths.filter(|path| seen.insert(*path)).collect()
}

fn entry(path: &str) -> Entry {
    Entry::of_argument(Path::new(path))
}

/// What is to be asked about each scenario: what of the batch is selected, and what an extension has more.
fn wanted(
    items: &[Item],
    selection: Selection,
    extended: Option<&Spec>,
    there: &HashSet<Identity<'_>>,
) -> Result<Vec<(Entry, Vec<Ask>)>, Failure> {
    let mut by_path: BTreeMap<&str, Vec<Ask>> = BTreeMap::new();
    let add = |asks: &mut Vec<Ask>, way: Way, variant: Variant, sample: u32| match asks
        .iter_mut()
        .find(|ask| ask.way == way && ask.variant == variant)
    {
        Some(ask) => ask.samples.push(sample),
        None => asks.push(Ask {
            way,
            variant,
            samples: vec![sample],
        }),
    };
    for item in items.iter().filter(|item| selection.has(item.state)) {
        let way = batch::way_of(&item.asked).map_err(Failure::input)?;
        let asks = by_path.entry(&item.asked.path).or_default();
        let variant = Variant::of(&item.asked).map_err(Failure::input)?;
        add(asks, way, variant, item.asked.sample);
    }
    let all = paths(items);
    if let Some(spec) = extended {
        let ways = spec.matrix.ways();
        for path in &all {
            let asks = by_path.entry(path).or_default();
            let varied = ways.iter().flat_map(|way| {
                let variants = spec.matrix.variants(way).into_iter();
                variants.map(move |variant| (way, variant))
            });
            for (way, variant) in varied {
                let techniques = way.techniques.map(|techniques| techniques.to_string());
                let (lead, transform) = variant.words();
                for sample in 0..spec.matrix.samples_of(way) {
                    let new = Identity {
                        path,
                        task: way.task.name(),
                        model: &way.model,
                        frame: way.frame.map(|frame| frame.name()),
                        techniques: techniques.as_deref(),
                        lead: lead.as_deref(),
                        transform: transform.as_deref(),
                        sample,
                    };
                    if !there.contains(&new) {
                        add(asks, way.clone(), variant, sample);
                    }
                }
            }
        }
    }
    let in_order = all.into_iter().filter_map(|path| {
        let asks = by_path.remove(path)?;
        (!asks.is_empty()).then(|| (entry(path), asks))
    });
    Ok(in_order.collect())
}

/// Refuses what would make another batch of one that is gone on with, and says what can be added instead.
pub fn all_stays(arguments: &Evaluate) -> Outcome {
    let options = &arguments.batch;
    let said = [
        (!arguments.paths.is_empty(), "scenarios", ""),
        (!arguments.model.is_empty(), "--model", "--add-model"),
        (!arguments.task.is_empty(), "--task", ""),
        (!options.frame.is_empty(), "--frame", ""),
        (
            !options.techniques.is_empty(),
            "--techniques",
            "--add-techniques",
        ),
        (
            !options.transform.is_empty(),
            "--transform",
            "--add-transform",
        ),
        (!arguments.lead.is_empty(), "--lead", "--add-lead"),
        (arguments.history.is_some(), "--history", ""),
        (arguments.radius.is_some(), "--radius", ""),
        (options.temperature.is_some(), "--temperature", ""),
        (options.max_tokens.is_some(), "--max-tokens", ""),
        (options.effort.is_some(), "--effort", ""),
        (options.base_url.is_some(), "--base-url", ""),
        (options.shard.is_some(), "--shard", ""),
    ];
    let Some((_, what, instead)) = said.into_iter().find(|(said, ..)| *said) else {
        return Ok(());
    };
    let instead = match instead {
        "" => "they cannot be added; begin a new batch, without --resume".to_string(),
        option => format!("{option} adds to it; for others begin a new batch, without --resume"),
    };
    Err(Failure::input(format!(
        "--resume goes on with the scenarios and ways of asking that the batch has, so {what} cannot be said: {instead}"
    )))
}
