//! Tests of the whole workbench without a terminal: messages in, model and frames out.
