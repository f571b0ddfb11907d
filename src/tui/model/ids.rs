//! Numbers of what is under way; what comes of an old one is dropped.

/// Numbers the jobs; an event of one that has ended is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct JobId(pub u64);

/// Numbers the openings; a message of an old one is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct OpenId(pub u64);

/// Numbers the lists of runs that are asked for; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct PageId(pub u64);

/// Numbers the requests for every measure; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct MeasureId(pub u64);

/// Numbers the requests for what is plotted; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct SeriesId(pub u64);

/// How far a job is; the last one tells its outcome.
#[derive(Debug)]
pub enum Update<P, T> {
    /// It goes on.
    Progress(P),
    /// It has ended: what came of it, or why it failed.
    Ended(Result<T, String>),
    /// It was cancelled, and has ended.
    Cancelled,
}
