//! A report independent of its format, explained number by number; as JSON, flat rows and self-contained HTML.

use std::borrow::Cow;

use nearmiss_record::{
    CaptionedTable, Column, HtmlPage, Kind, Record, Row, Table, columns, escaped_html as escaped,
    escaped_latex, escaped_markdown, latex_comment,
};
use nearmiss_store::SplitPart;
use schemars::JsonSchema;
use serde::Serialize;

use super::super::statistics::{DRAWS, EXACT_BELOW, EXACT_UP_TO, FEWEST, RESAMPLES, SEED};
use super::super::{Cluster, Leak};
use super::contents::{RuleRow, record_rows};
use super::pivot::AxesDocument;
use super::{
    AtPrevalence, Cell, ComparisonRow, InvarianceRow, LeadRow, Pair, PartProgress, Report,
    ReportSubject,
};
use crate::evaluation::AnswerPage;

/// A whole report.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Document {
    /// Its title.
    pub title: String,
    /// Its contents.
    pub blocks: Vec<Block>,
}

/// A part of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A table.
    Table(CaptionedTable),
    /// Figures of one kind, side by side, and what they show; only HTML has them.
    Figures(String, Vec<Figure>),
}

/// A picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// Its caption.
    pub caption: String,
    /// The picture as SVG, its texts escaped.
    pub svg: String,
}

impl Document {
    /// The report as Markdown; figures are left out.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n", escaped_markdown(&self.title));
        for block in &self.blocks {
            match block {
                Block::Heading(words) => text += &format!("\n## {}\n", escaped_markdown(words)),
                Block::Text(words) => text += &format!("\n{}\n", escaped_markdown(words)),
                Block::Table(table) => text += &table.markdown(),
                Block::Figures(..) => {}
            }
        }
        text
    }

    /// The tables as LaTeX, for `\input`, each with its notes beneath; figures are left out, and headings and
    /// paragraphs are comments.
    #[must_use]
    pub fn latex(&self) -> String {
        let mut text = latex_comment(&self.title);
        text += "% \\usepackage{booktabs,graphicx}\n";
        for block in &self.blocks {
            match block {
                Block::Heading(words) => text += &format!("\n%\n{}", latex_comment(words)),
                Block::Text(words) => text += &latex_comment(words),
                Block::Table(table) => text += &table.latex(),
                Block::Figures(..) => {}
            }
        }
        text
    }
}

impl Document {
    /// The document as LaTeX that compiles by itself: headings, paragraphs and tables; figures are left out.
    #[must_use]
    pub fn latex_article(&self) -> String {
        let title = escaped_latex(&self.title);
        let mut text =
            format!("{ARTICLE}\\title{{{title}}}\n\\date{{}}\n\\begin{{document}}\n\\maketitle\n");
        for block in &self.blocks {
            match block {
                Block::Heading(words) => {
                    text += &format!("\n\\section*{{{}}}\n", escaped_latex(words));
                }
                Block::Text(words) => text += &format!("\n{}\n", escaped_latex(words)),
                Block::Table(table) => text += &table.latex_long(PAGE),
                Block::Figures(..) => {}
            }
        }
        text + "\n\\end{document}\n"
    }
}

/// The head of a document that compiles by itself, on A4 across.
const ARTICLE: &str = "\\documentclass{article}\n\\usepackage[utf8]{inputenc}\n\\usepackage[T1]{fontenc}\n\
    \\usepackage[a4paper,landscape,margin=20mm]{geometry}\n\\usepackage{array,booktabs,longtable}\n\
    \\setlength{\\parindent}{0pt}\n\\setlength{\\parskip}{4pt}\n";

/// Its width between the margins, millimetres.
const PAGE: f64 = 257.0;

/// A row with the part of a split that it is of.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct InSplit<R> {
    /// The row.
    #[serde(flatten)]
    pub row: R,
    /// The part, dev or test; missing without a split.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub split: Option<&'static str>,
}

impl<R> InSplit<R> {
    /// Rows of a part of a split, or of a batch without one.
    pub fn all(split: Option<SplitPart>, rows: impl IntoIterator<Item = R>) -> Vec<Self> {
        let split = split.map(SplitPart::name);
        let rows = rows.into_iter();
        rows.map(|row| Self { row, split }).collect()
    }
}

/// How the 95 % intervals are computed.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct IntervalMethods {
    /// Their level.
    pub level: f64,
    /// What is drawn as a whole: scenario or map.
    pub unit: String,
    /// How those of proportions are computed.
    pub proportions: String,
    /// How those of F1 are computed.
    pub f1: String,
    /// Draws of the bootstrap.
    pub resamples: usize,
    /// How configurations are compared.
    pub comparisons: String,
    /// Random permutations, where not all are tried.
    pub permutations: usize,
    /// Seed of all draws.
    pub seed: u64,
}

impl IntervalMethods {
    fn new(unit: Cluster) -> Self {
        Self {
            level: 0.95,
            unit: unit.to_string(),
            proportions: format!(
                "Wilson with one answer a {unit}, else percentile bootstrap over {unit}s"
            ),
            f1: format!("percentile bootstrap over {unit}s"),
            resamples: RESAMPLES,
            comparisons: format!("paired permutation test by {unit}"),
            permutations: DRAWS,
            seed: SEED,
        }
    }
}

/// A report for programs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ReportDocument {
    /// One prompt configuration each, on half of the data or all of it.
    pub cells: Vec<InSplit<Cell>>,
    /// Paired permutation tests between prompt configurations, by scenario or map.
    pub pairs: Vec<InSplit<Pair>>,
    /// How the 95 % intervals are computed.
    pub intervals: IntervalMethods,
    /// Which answers these are, and beside which truth.
    #[serde(flatten)]
    pub about: ReportSubject,
    /// Which verdicts changed on transformed scenes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub invariance: Vec<InSplit<InvarianceRow>>,
    /// Results by lead of the safety task.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lead: Vec<InSplit<LeadRow>>,
    /// Tables over axes that were declared with the batch.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tables: Vec<InSplit<AxesDocument>>,
    /// What trivial rules come to on the same questions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<InSplit<RuleRow>>,
    /// What the configurations come to at another share of dangerous questions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub prevalence: Vec<InSplit<AtPrevalence>>,
    /// How well position, length and traffic of the questions tell their answers, by lead.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub leaks: Vec<InSplit<Leak>>,
    /// Published numbers beside those recomputed, with --paper.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub comparisons: Vec<ComparisonRow>,
    /// Of a batch with a split: the progress of each part, whether it is locked, and looks at it before it was complete.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub splits: Vec<PartProgress>,
}

impl ReportDocument {
    /// Of a batch or of a part of its split.
    fn new(report: &Report, part: Option<SplitPart>) -> Self {
        Self {
            cells: InSplit::all(part, report.cells.iter().cloned()),
            pairs: InSplit::all(part, report.pairs.iter().cloned()),
            intervals: IntervalMethods::new(report.unit()),
            about: report.about.clone(),
            invariance: InSplit::all(part, report.varied.changes()),
            lead: InSplit::all(part, report.varied.by_lead()),
            tables: InSplit::all(part, report.tables.iter().map(AxesDocument::from)),
            rules: InSplit::all(part, report.rules.iter().map(RuleRow::from)),
            prevalence: InSplit::all(part, report.prevalence.iter().cloned()),
            leaks: InSplit::all(part, report.leaks.iter().cloned()),
            comparisons: Vec::new(),
            splits: Vec::new(),
        }
    }

    /// Of the parts of a split: their lists one after the other, each row with its part.
    pub(super) fn of_parts(parts: &[(SplitPart, Report)]) -> Self {
        let documents = { parts.iter() }.map(|(part, report)| Self::new(report, Some(*part)));
        let joined = documents.reduce(|mut all, part| {
            all.cells.extend(part.cells);
            all.pairs.extend(part.pairs);
            all.invariance.extend(part.invariance);
            all.lead.extend(part.lead);
            all.tables.extend(part.tables);
            all.rules.extend(part.rules);
            all.prevalence.extend(part.prevalence);
            all.leaks.extend(part.leaks);
            let known = all.about.notes.clone();
            let notes = part.about.notes.into_iter();
            all.about
                .notes
                .extend(notes.filter(|note| !known.contains(note)));
            all
        });
        joined.unwrap_or_else(|| Self::new(&Report::default(), None))
    }
}

impl Report {
    /// The report for programs; missing values are null.
    #[must_use]
    pub fn json(&self) -> ReportDocument {
        ReportDocument::new(self, None)
    }
}

/// Rows with their columns.
#[derive(Debug, Clone)]
pub struct FlatRows {
    /// The columns.
    pub table: Table,
    /// A cell for each.
    pub rows: Vec<Row>,
}

impl FlatRows {
    /// The rows of parts of a report, with the batch, the truth and, where it is one, the part of its split as the last
    /// columns.
    #[must_use]
    pub fn new<R: Record>(parts: &[(&ReportSubject, Vec<R>)]) -> Self {
        let text = |name| Column::new(name, Kind::Text, "", "").optional();
        let has_split = parts.iter().any(|(about, _)| about.split.is_some());
        let mut columns = columns::<R>();
        columns.extend([text("batch"), text("truth")]);
        columns.extend(has_split.then(|| text("split")));
        let word = |word: Option<String>| {
            word.map_or(nearmiss_record::Cell::None(""), nearmiss_record::Cell::from)
        };
        let of_part = |(about, records): &(&ReportSubject, Vec<R>)| {
            let mut rows = record_rows(records);
            for row in &mut rows {
                let truth = Some(about.truth.words.clone());
                row.extend([word(about.batch.clone()), word(truth)]);
                row.extend(has_split.then(|| word(about.split.map(String::from))));
            }
            rows
        };
        Self {
            rows: parts.iter().flat_map(of_part).collect(),
            table: Table::new("report", columns),
        }
    }

    /// The same under other names of columns; those without one are left out.
    pub(super) fn renamed(mut self, name: impl Fn(&str) -> Option<Cow<'static, str>>) -> Self {
        let names: Vec<_> = { self.table.columns.iter() }
            .map(|column| name(&column.name))
            .collect();
        for row in &mut self.rows {
            let kept = row.drain(..).zip(&names);
            *row = kept
                .filter_map(|(cell, name)| name.as_ref().map(|_| cell))
                .collect();
        }
        let columns = self.table.columns.drain(..).zip(names);
        let columns = columns.filter_map(|(column, name)| {
            Some(Column {
                name: name?,
                ..column
            })
        });
        self.table.columns = columns.collect();
        self
    }

    /// As CSV with a header.
    #[must_use]
    pub fn csv(self) -> String {
        String::from_utf8_lossy(&self.table.csv(self.rows)).into_owned()
    }
}

impl Report {
    /// The cells, one row each.
    #[must_use]
    pub fn rows(&self) -> FlatRows {
        FlatRows::new(&[(&self.about, self.cells.clone())])
    }

    /// The comparisons of ways, one row each.
    #[must_use]
    pub fn pair_rows(&self) -> FlatRows {
        FlatRows::new(&[(&self.about, self.pairs.clone())])
    }
}

/// The look of reports; figures in SVG have its colours too.
const STYLE: &str = include_str!("report.css");

impl Document {
    /// The report as one file of HTML, with its figures in it, and the answers that it counts where there are any. The
    /// page runs nothing but its own script and asks for nothing.
    #[must_use]
    pub fn html(&self, answers: &AnswerPage) -> String {
        let mut page = HtmlPage {
            title: self.title.clone(),
            style: STYLE.into(),
            body: format!("<main>\n<h1>{}</h1>\n", escaped(&self.title)),
            script: "",
        };
        for block in &self.blocks {
            page.body += &match block {
                Block::Heading(words) => format!("<h2>{}</h2>\n", escaped(words)),
                Block::Text(words) => format!("<p>{}</p>\n", escaped(words)),
                Block::Table(table) => table.html(),
                Block::Figures(title, figures) => {
                    let title = escaped(title);
                    let figures: String = figures.iter().map(figure_html).collect();
                    format!("<h3>{title}</h3>\n<div class=\"figures\">\n{figures}</div>\n")
                }
            };
        }
        page.body += "</main>\n";
        if !answers.is_empty() {
            answers.add_to(&mut page);
        }
        page.html()
    }
}

/// A figure, with its caption if it has one.
fn figure_html(figure: &Figure) -> String {
    let caption = if figure.caption.is_empty() {
        String::new()
    } else {
        format!("<figcaption>{}</figcaption>\n", escaped(&figure.caption))
    };
    format!("<figure>\n{}{caption}</figure>\n", figure.svg)
}

/// Everything, in the order of the tables.
pub(super) fn all(unit: Cluster) -> impl Iterator<Item = String> {
    let last = [claims(unit), samples(), consumption()].join(" ");
    let all = [
        counts(),
        intervals(unit),
        pairs(unit),
        naming(),
        calibration(),
        last,
    ];
    all.into_iter()
}

pub(super) fn counts() -> String {
    "n is every question, answered or not: TP, FP, FN and TN are verdicts beside the truth; unparsed answers hold no \
     verdict, failed questions were asked and have no whole answer (an answer that was cut off or filtered is none, \
     whatever it says), others were not asked, or not yet. Right of all: the share of the questions asked, with a truth, \
     whose verdict is right; a question without a verdict is not. Precision, recall, specificity, accuracy and F1 are of \
     the verdicts alone. Yes and no are counted as said, whichever obstacle is named."
        .into()
}

pub(super) fn intervals(unit: Cluster) -> String {
    let with = match unit {
        Cluster::Scenario => "windows and samples",
        Cluster::Map => "scenarios, windows and samples",
    };
    format!(
        "Intervals are of 95 %, with the {unit} as the unit: the percentile bootstrap over {unit}s with all their \
         {with} ({RESAMPLES} resamples, seed {SEED}; Efron 1979, Davison and Hinkley 1997), as answers about \
         one {unit} are not independent; so are those of named obstacles, leads and transformed scenes. Shares of \
         answers of which each {unit} has one have Wilson's interval; so have shares of 0 and 1, where the bootstrap \
         cannot vary, with the {unit}s as observations. F1 has no interval where no draw differs. Below {FEWEST} \
         {unit}s no interval is given."
    )
}

pub(super) fn pairs(unit: Cluster) -> String {
    format!(
        "Difference: the mean over {unit}s of the first's share of questions that are right of those asked minus the \
         second's, where no verdict is not right, with its bootstrap interval. p is that of the paired permutation test by {unit} (Fisher 1935): the share of \
         assignments of signs to the {unit}s' differences whose sum is as far from 0, all of them for up to \
         {EXACT_UP_TO} {unit}s that differ, else {DRAWS} random ones (seed {SEED}). p (Holm) is corrected for the \
         comparisons of the same family and task (Holm 1979): a single declared comparison (--compare) is not corrected, \
         those with the baseline (--baseline) are together, and without a baseline all pairs that differ in frame, \
         techniques, model or template alone. Detectable: the difference that would be found with a power of 80 % at a \
         level of 5 %, (1.96 + 0.84)·√(mean d²/n) of n {unit}s' differences d (Connor 1987, Miller 2024); a smaller true \
         difference is likely missed. Ties: {unit}s on which the questions of one are as often right as wrong; they count \
         by half. JSON and CSV have McNemar's test of majorities, which leaves ties out (exact below {EXACT_BELOW} \
         discordant {unit}s)."
    )
}

pub(super) fn naming() -> String {
    "Windows are the dangerous ones, with a verdict, whose critical obstacles are known. Obstacle named: the share of \
     them of which the answer names one (recall of naming); named worst: no obstacle has a graver risk score. Names are the \
     obstacles named over these and the safe windows; names right: the share that is truly critical (precision of \
     naming), so a yes on a safe window names only bystanders. An answer names the critical_obstacles of a yes; one without \
     that list, those of risk score 0 or 1, or of 2 if that is the gravest of a yes. κ is Cohen's, of yes and no beside \
     the built-in judge."
        .into()
}

pub(super) fn calibration() -> String {
    "Every verdict beside a truth has a probability of yes: the one that the answer states; else the largest of its \
     critical_obstacles; else that of its log probabilities; else 1 − s/5 with its gravest risk score s as written; \
     else 1 for yes and 0 for no. The columns say how many are from each. Brier is the mean square of what they miss; AUROC the probability that a yes in truth has a \
     higher one than a no, ties counted half; ECE has ten bins of the same width."
        .into()
}

pub(super) fn token_calibration() -> String {
    "Log probabilities: of the tokens with which an answer decides, e^l of those that begin a yes over that of those that \
     begin a yes or a no, among the alternatives that the server lists; of the verdicts for which it gives them."
        .into()
}

pub(super) fn samples() -> String {
    "Samples: unanimous is the share of questions on which all samples agree, agreement the share of pairs of samples \
     that do (Fleiss 1971). All right: the chance that all k samples of a question are right, pass^k, with k the number \
     of samples; C(r, k)/C(n, k) of r right among n answers (Chen et al. 2021, Yao et al. 2024), over questions with k \
     answers; one without a verdict is wrong. Ties have yes and no equally often; undecided are these and questions without any verdict; coverage is the share of questions \
     with a majority, and the majority's counts and F1 are of these alone."
        .into()
}

pub(super) fn claims(unit: Cluster) -> String {
    format!(
        "Claims of whole answers about an obstacle or the ego are found and checked against the geometry as `nearmiss help \
         answers` says. Open: it depends on what is meant. Invented: wrong numbers that the question does not have. Sentences \
         are those that say something of the scene; contradictory: they contradict another one; not understood: their share, \
         neither right nor wrong. Wrong share: the wrong claims of those that are right or wrong, with the bootstrap over \
         {unit}s. Not checked: the scenario of the answer was not at hand."
    )
}

pub(super) fn consumption() -> String {
    "Tokens and dollars are of every attempt at a question: answers that were cut off or filtered, and superseded \
     attempts, in whose place another one counts; deleted runs are left out. Times are of the answers that count. \
     Unknown costs and times are counted, never taken as 0; at most: what attempts of unknown cost can have cost, where \
     a price and a limit bound it. The built-in judge and questions that were not sent cost nothing."
        .into()
}
