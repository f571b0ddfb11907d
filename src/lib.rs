//! A workbench for safety-critical driving scenarios: reading, measuring, describing, asking, comparing.
