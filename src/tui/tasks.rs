//! Requests of the workbench: what is asked, the work, and the reply.
