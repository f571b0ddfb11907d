//! Asks a model to put sentences that the rules do not understand into the claim language, each question once.

use std::sync::atomic::{AtomicBool, Ordering};

use futures_util::StreamExt;
use nearmiss_ask::llm::{Message, Request, Role, Schema};
use nearmiss_store::Store;
use nearmiss_study::evaluation::ModelJudge;
use nearmiss_study::evaluation::claims::{
    CheckedSentence, Subject, Untranslated, translation_schema, untranslated,
};

use crate::ask::{TextError, TextQuestion};

/// The model that reads again, and where its answers are kept.
#[derive(Debug, Clone, Copy)]
pub struct SecondReader<'a> {
    /// The model, with its budget.
    pub model: &'a ModelJudge,
    /// The store for its answers, also searched for existing ones.
    pub store: &'a Store,
    /// Questions on their way at once.
    pub at_once: usize,
}

/// What a second reader did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SecondReading {
    /// Sentences that the rules did not understand, and that could be asked about.
    pub asked: usize,
    /// Those of them that are decided or open now.
    pub read: usize,
    /// Questions that were sent.
    pub questions: usize,
    /// What they cost, US dollars; `None` if that is unknown of one.
    pub usd: Option<f64>,
    /// Why questions have no answer of use, each once.
    pub failed: Vec<String>,
}

/// What a second reader would be asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondEstimate {
    /// Sentences that the rules do not understand.
    pub sentences: usize,
    /// Questions to be sent.
    pub questions: usize,
    /// The most that they can cost, US dollars; `None` if that is not known.
    pub usd: Option<f64>,
}

/// A text with what the rules made of it.
pub type ReadText<'a> = (Subject<'a>, &'a str, Vec<CheckedSentence>);

impl SecondReader<'_> {
    fn request(&self, asked: &Untranslated) -> Request {
        Request {
            model: self.model.name.clone(),
            messages: vec![
                Message::new(Role::System, asked.system.as_str()),
                Message::new(Role::User, asked.user.as_str()),
            ],
            parameters: self.model.parameters,
            schema: Some(Schema {
                is_bounded: false,
                name: "translations".into(),
                schema: translation_schema(),
            }),
            tools: None,
        }
    }

    /// How many questions texts need, how many sentences these have, and the most that they can cost, US dollars, where that is
    /// known; answers that the store has cost nothing.
    ///
    /// # Errors
    /// The store failed.
    pub fn estimate(&self, texts: &[ReadText<'_>]) -> Result<SecondEstimate, String> {
        let mut all = SecondEstimate {
            sentences: 0,
            questions: 0,
            usd: Some(0.0),
        };
        let questions =
            { texts.iter() }.flat_map(|(subject, text, found)| untranslated(text, found, subject));
        for asked in questions {
            all.sentences += asked.places.len();
            let request = self.request(&asked);
            let most = self.model.endpoint.at_most(&request);
            let stored = TextQuestion::new(self.model, request, 0).stored(self.store);
            if stored.map_err(|why| why.to_string())?.is_none() {
                all.questions += 1;
                all.usd = all.usd.zip(most).map(|(all, one)| all + one);
            }
        }
        Ok(all)
    }

    /// Reads the sentences of texts that the rules did not understand. A question without an answer leaves its sentences as
    /// they are; where nothing more can be asked, all later ones.
    ///
    /// # Errors
    /// The store failed.
    pub async fn read(&self, texts: &mut [ReadText<'_>]) -> Result<SecondReading, String> {
        let mut done = SecondReading {
            usd: Some(0.0),
            ..SecondReading::default()
        };
        let questions: Vec<(usize, Untranslated)> = { texts.iter().enumerate() }
            .flat_map(|(at, (subject, text, found))| {
                let all = untranslated(text, found, subject).into_iter();
                all.map(move |asked| (at, asked))
            })
            .collect();
        let is_stopped = &AtomicBool::new(false);
        let asking = questions
            .iter()
            .map(|(at, asked)| async move { (*at, asked, self.answer(asked, is_stopped).await) });
        let mut answers = futures_util::stream::iter(asking).buffered(self.at_once.max(1));
        while let Some((at, asked, answer)) = answers.next().await {
            done.asked += asked.places.len();
            let why = match answer {
                Ok(reply) => {
                    if reply.is_new {
                        done.questions += 1;
                        done.usd = done.usd.zip(reply.usd).map(|(all, one)| all + one);
                    }
                    let (subject, own, found) = &mut texts[at];
                    let read = reply
                        .text
                        .and_then(|text| asked.read((own, found), &text, subject));
                    read.map(|count| done.read += count).err()
                }
                Err(TextError::Store(error)) => return Err(error.to_string()),
                Err(TextError::Failed(why)) => Some(why),
                // What is on its way, and what the store has, is read; nothing is begun.
                Err(TextError::Stopped(why)) => {
                    is_stopped.store(true, Ordering::Relaxed);
                    Some(why)
                }
            };
            if let Some(why) = why.filter(|why| !done.failed.contains(why)) {
                done.failed.push(why);
            }
        }
        Ok(done)
    }

    /// The answer to a question: that of the store, or a new one while more can be asked.
    async fn answer(
        &self,
        asked: &Untranslated,
        is_stopped: &AtomicBool,
    ) -> Result<Reply, TextError> {
        let question = TextQuestion::new(self.model, self.request(asked), 0);
        // An answer that was cut off, or is of another form, is not worth keeping to.
        if let Some(Ok(text)) = question.stored(self.store)?
            && Untranslated::is_answer(&text)
        {
            return Ok(Reply {
                text: Ok(text),
                is_new: false,
                usd: None,
            });
        }
        if is_stopped.load(Ordering::Relaxed) {
            return Err(TextError::Failed("later questions were not sent".into()));
        }
        let (text, consumed) = question.ask(self.store).await?;
        Ok(Reply {
            text,
            is_new: true,
            usd: consumed.cost_usd,
        })
    }
}

/// What a question led to.
struct Reply {
    text: Result<String, String>,
    /// Whether it was sent now.
    is_new: bool,
    /// What it cost, US dollars, where that is known.
    usd: Option<f64>,
}
