//! The annex as a document: requirement, results, findings, scenarios, test environment, and what it does not show.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use nearmiss_base::system::counted;
use nearmiss_drive::driver::{DRIVERS, driver};
use nearmiss_drive::simulation::TrafficMode;
use nearmiss_record::{CaptionedTable, Record};
use nearmiss_study::evaluation::report::{Block, Document, Figure};
use nearmiss_study::evaluation::statistics::{FEWEST, RESAMPLES, SEED};

use crate::RateLike;

use super::{Annex, AnnexDrive, Finding, PlannerFindings, Role};

/// Pictures of contacts in the document; the table has all.
const PICTURES: usize = 24;

/// What it does not show, a paragraph each, beside what traffic does.
const LIMITS: &[&str] = &[
    "Credibility of the simulation: nothing here validates it. The ego is a kinematic single-track vehicle on a dry, flat \
     road; planners and drivers see every obstacle exactly and without delay; sensors, actuators and weather are not \
     simulated.",
    "Drivers are the models of UN Regulation 157 and others, made for motorways. The UN regulation on automated driving \
     systems (2026) asks for the level of a competent and careful human driver and prescribes no model. What a model was \
     not made for is open here.",
    "A driver sits in the planner's seat from 5 s before the contact: how the planner came there is not the driver's doing.",
    "Scenarios were chosen, not drawn from traffic: shares are of these scenarios. How often such manoeuvres are met is \
     that of the index, if one is named, and of its roads, countries and hours.",
    "The operational design domain is quoted, not checked; tags are ours, after the categories of ISO 34504.",
    "No contact is not competence: standing still avoids contact, too. Read the goals beside.",
    "A driver has no contact that it would avoid itself: rows of drivers and baselines are for comparison, not findings.",
    "Verdicts near a boundary change with a small change of the scenario: `nearmiss drivers FILE --vary` shows how near.",
    "It is one kind of evidence for a safety case, no statement of conformity.",
];

/// Terms of regulations, and what stands for them here.
const TERMS: &[(&str, &str)] = &[
    (
        "competent and careful human driver",
        "the driver that the requirement names",
    ),
    (
        "preventable, unpreventable",
        "this driver avoids the contact in the planner's seat, or does not; no model proves that none could",
    ),
    (
        "mitigation",
        "a contact no harder than the driver's: closing speed less than 0.5 m/s above it",
    ),
    (
        "foreseeable",
        "how often the index holds manoeuvres that are at least as extreme; no threshold",
    ),
    (
        "test environment",
        "virtual: the closed-loop simulation of nearmiss",
    ),
    (
        "serious injury",
        "MAIS3+ of the people at most risk, by published curves",
    ),
];

fn table<R: Record + schemars::JsonSchema + serde::Serialize>(
    caption: &str,
    name: &str,
    records: &[R],
) -> Option<CaptionedTable> {
    // Records without maps have no keys that JSON does not allow.
    CaptionedTable::of(caption, name, records).ok()?.filled()
}

fn words(caption: &str, name: &str, titles: &[&str], rows: Vec<Vec<String>>) -> CaptionedTable {
    CaptionedTable {
        caption: caption.into(),
        name: name.into(),
        columns: titles
            .iter()
            .map(|title| ((*title).into(), false))
            .collect(),
        rows,
        notes: Vec::new(),
    }
}

impl PlannerFindings {
    /// The result in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let mut parts = vec![
            format!("{} reach the goal", self.goal),
            format!("{} without contact", self.no_contact),
        ];
        let counts = [
            (
                self.unpreventable,
                "with a contact that the driver does not avoid either",
            ),
            (self.harder, "with such a contact, harder than the driver's"),
            (self.preventable, "with a contact that the driver avoids"),
            (self.open, "open"),
        ];
        let told = counts.iter().filter(|(count, _)| *count > 0);
        parts.extend(told.map(|(count, words)| format!("{count} {words}")));
        let verdict = match self.met {
            Some(true) => "met",
            Some(false) => "not met",
            None => "open",
        };
        format!(
            "{}: {verdict}. Of {} drives: {}.",
            self.planner,
            self.drives,
            parts.join(", ")
        )
    }
}

impl Annex {
    /// The annex for people.
    #[must_use]
    pub fn document(&self) -> Document {
        let requirement = &self.requirement;
        let mut blocks = Vec::new();
        let heading = |words: &str| Block::Heading(words.into());
        let text = |words: String| Block::Text(words);
        blocks.push(heading("Requirement"));
        blocks.push(text(requirement.text.clone()));
        blocks.extend(
            requirement
                .source
                .iter()
                .map(|source| text(format!("Source: {source}"))),
        );
        blocks.extend(
            requirement
                .odd
                .iter()
                .map(|odd| text(format!("Operational design domain: {odd}"))),
        );
        if let Ok(model) = driver(&requirement.driver) {
            blocks.push(text(format!(
                "Planners are held to the driver {} ({}): what it avoids in their seat they have to avoid, and what it does \
                 not, they must not hit harder by 0.5 m/s or more. It was not made for: {}.",
                model.id,
                model.name,
                { model.not_made_for.iter() }.map(|kind| kind.words()).collect::<Vec<_>>().join(", ")
            )));
        }
        blocks.push(heading("Results"));
        let planners = self.planners();
        let held = planners.iter().filter(|one| one.role == Role::Planner);
        blocks.extend(held.map(|one| text(one.sentence())));
        blocks.extend(self.cautions().into_iter().map(text));
        let caption = "Planners, and drivers and baselines for comparison";
        blocks.extend(table(caption, "planners", &planners).map(Block::Table));
        blocks.extend(self.findings());
        blocks.push(heading("Drivers and baselines"));
        let caption = "Contacts, with each driver in the same seat";
        blocks.extend(table(caption, "contacts", &self.contacts()).map(Block::Table));
        let caption = "Outcomes, harm, and differences from the first planner, paired by scenario";
        blocks.extend(table(caption, "standings", &self.standings()).map(Block::Table));
        blocks.push(heading("Scenarios"));
        let scenarios: Vec<_> = self.held.iter().map(|held| held.scenario.clone()).collect();
        blocks.extend(
            table(
                "Scenarios, with tags after ISO 34504",
                "scenarios",
                &scenarios,
            )
            .map(Block::Table),
        );
        let rates: Vec<RateLike> = self
            .held
            .iter()
            .flat_map(|held| held.rates.clone())
            .collect();
        let foreseeable = "How often the index holds manoeuvres that are at least as extreme, and who avoids those of the scenarios";
        blocks.extend(table(foreseeable, "rates", &rates).map(Block::Table));
        let missed = self
            .missed
            .iter()
            .map(|(name, why)| vec![name.clone(), why.clone()]);
        let missed = words(
            "Scenarios that were not driven",
            "missed",
            &["scenario", "why"],
            missed.collect(),
        );
        blocks.extend(missed.filled().map(Block::Table));
        let drives: Vec<AnnexDrive> = self
            .held
            .iter()
            .flat_map(|held| held.drives.clone())
            .collect();
        blocks.extend(table("Every drive", "drives", &drives).map(Block::Table));
        blocks.extend(self.environment(&planners));
        blocks.push(heading("What it does not show"));
        blocks.push(text(self.traffic().into()));
        blocks.extend(LIMITS.iter().map(|limit| text((*limit).into())));
        blocks.push(heading("Terms"));
        let terms = TERMS
            .iter()
            .map(|(term, here)| vec![(*term).into(), (*here).into()]);
        blocks.push(Block::Table(words(
            "Terms of UN regulations and ISO 34502, and what stands for them here",
            "terms",
            &["term", "here"],
            terms.collect(),
        )));
        Document {
            title: format!("{} {}", requirement.id, requirement.title),
            blocks,
        }
    }

    /// What makes the shares less than they seem.
    fn cautions(&self) -> Vec<String> {
        let scenarios = || self.held.iter().map(|held| &held.scenario);
        let all = counted(self.held.len(), "scenario");
        let mut found = Vec::new();
        if let Some(select) = self.requirement.select.as_ref() {
            let not = self.held.len() + self.missed.len() + self.copies.len();
            found.push(format!(
                "{not} of {} were selected: {select}.",
                counted(self.listed, "scenario")
            ));
        }
        if !self.copies.is_empty() {
            let copies = counted(self.copies.len(), "scenario");
            found.push(format!(
                "{copies} left out, with the content of another: {}.",
                self.copies.join(", ")
            ));
        }
        let first = self.who.first().map_or("", |(name, _)| name);
        let beyond = self.beyond_baselines().words(self.held.len(), first);
        found.push(format!(
            "Of the scenarios {beyond}. What a baseline solves tells little of a planner."
        ));
        let mut against: BTreeMap<&str, usize> = BTreeMap::new();
        for planner in scenarios().filter_map(|one| one.made_against.as_deref()) {
            *against.entry(planner).or_default() += 1;
        }
        found.extend(against.iter().map(|(planner, count)| {
            format!(
                "{count} of {all} hold attacks that were searched against {planner}: its share is not comparable with \
                 those of others there."
            )
        }));
        if !self.missed.is_empty() {
            found.push(format!(
                "{} could not be driven by all: nothing is met as a whole.",
                counted(self.missed.len(), "scenario")
            ));
        }
        let in_index = scenarios().filter(|one| one.in_index).count();
        if in_index > 0 {
            found.push(format!(
                "{in_index} of {all} are in the index themselves: rates of manoeuvres like theirs are too high."
            ));
        }
        found
    }

    /// What speaks against planners, with maps, and what is open.
    fn findings(&self) -> Vec<Block> {
        let of = |findings: &[Finding]| -> Vec<AnnexDrive> {
            let drives = self.held.iter().flat_map(|held| &held.drives);
            let found = drives
                .filter(|drive| drive.role == Role::Planner && findings.contains(&drive.finding));
            found.cloned().collect()
        };
        let against = of(&[Finding::Preventable, Finding::Harder]);
        let open = of(&[Finding::Open]);
        let mut blocks = vec![Block::Heading("Findings".into())];
        if against.is_empty() {
            blocks.push(Block::Text(
                "No drive of a planner speaks against the requirement.".into(),
            ));
        }
        blocks.extend(
            table(
                "Drives that do not meet the requirement",
                "against",
                &against,
            )
            .map(Block::Table),
        );
        let figures: Vec<Figure> = self
            .pictures()
            .take(PICTURES)
            .map(|(caption, svg)| Figure {
                caption: caption.clone(),
                svg: svg.clone(),
            })
            .collect();
        if !figures.is_empty() {
            let title = format!("Contacts, {} of {}", figures.len(), self.pictures().count());
            blocks.push(Block::Figures(title, figures));
        }
        blocks.extend(table("Open: nothing can be said", "open", &open).map(Block::Table));
        blocks
    }

    /// Program, settings, planners, drivers, hashes.
    fn environment(&self, planners: &[PlannerFindings]) -> Vec<Block> {
        let provenance = self.provenance();
        let mut facts: Vec<Vec<String>> = vec![
            vec!["program".into(), provenance.program.clone()],
            vec![
                "commit".into(),
                provenance
                    .commit
                    .clone()
                    .unwrap_or_else(|| "not known".into()),
            ],
            vec!["SHA-256 of the program".into(), self.program_sha256.clone()],
            vec!["driven on".into(), self.day.clone()],
            vec![
                "SHA-256 of the requirement's file".into(),
                self.file_sha256.clone(),
            ],
            vec!["scenarios".into(), provenance.scenarios.to_string()],
            vec![
                "SHA-256 of their sorted hashes".into(),
                provenance.scenarios_sha256.clone().unwrap_or_default(),
            ],
        ];
        let named = |paths: &[PathBuf]| -> String {
            let paths: Vec<String> = paths
                .iter()
                .map(|path| path.display().to_string())
                .collect();
            paths.join(", ")
        };
        let requirement = &self.requirement;
        facts.push(vec!["files".into(), named(&requirement.scenarios)]);
        facts.extend(
            requirement
                .select
                .iter()
                .map(|select| vec!["select".into(), select.clone()]),
        );
        facts.extend(
            requirement
                .index
                .iter()
                .map(|index| vec!["index".into(), index.display().to_string()]),
        );
        let steps: BTreeSet<String> = { self.held.iter() }
            .map(|held| format!("{} s", held.scenario.time_step))
            .collect();
        facts.push(vec![
            "time steps".into(),
            steps.into_iter().collect::<Vec<_>>().join(", "),
        ]);
        facts.push(vec![
            "contact".into(),
            "of exact bodies, at the steps and between them".into(),
        ]);
        facts.push(vec![
            "intervals".into(),
            format!("95 %, scenarios on one map together, from {FEWEST} on; percentile bootstrap ({RESAMPLES} resamples, seed {SEED}) or Wilson"),
        ]);
        let identities = planners.iter().filter_map(|one| {
            let identity = one.identity.clone()?;
            Some(vec![format!("planner {}", one.planner), identity])
        });
        facts.extend(identities);
        facts.extend(
            self.planning()
                .into_iter()
                .map(|(key, value)| vec![key, value.to_string()]),
        );
        let models = DRIVERS.iter().map(|model| {
            vec![
                model.id.into(),
                model.name.into(),
                model.source.into(),
                model.limits.into(),
            ]
        });
        let hashes = self
            .held
            .iter()
            .map(|held| vec![held.scenario.scenario.clone(), held.scenario.sha256.clone()]);
        vec![
            Block::Heading("Test environment".into()),
            Block::Table(words(
                "Program, settings and hashes",
                "environment",
                &["", "value"],
                facts,
            )),
            Block::Table(words(
                "Drivers",
                "drivers",
                &["id", "driver", "source", "limits"],
                models.collect(),
            )),
            Block::Table(words(
                "SHA-256 of the scenarios",
                "hashes",
                &["scenario", "SHA-256"],
                hashes.collect(),
            )),
        ]
    }

    fn traffic(&self) -> &'static str {
        match self.requirement.planning.traffic {
            TrafficMode::Recorded => {
                "Traffic follows its recording and reacts to nothing: contacts from behind by traffic that does not see \
                 the ego brake are open."
            }
            TrafficMode::Reactive => {
                "Traffic that comes near the ego reacts by the Intelligent Driver Model: what others would really do is \
                 not known."
            }
        }
    }
}
