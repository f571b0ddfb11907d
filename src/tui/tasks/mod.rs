//! Requests of the workbench: what is asked, the work, and the reply.

pub mod asking;
pub mod batch;
pub mod drives;
pub mod experiment;
pub mod history;
pub mod index;
pub mod making;
pub mod pictures;
pub mod planning;
pub mod rating;
pub mod results;
pub mod scenarios;
pub mod session;
pub mod templates;
pub mod thresholds;
