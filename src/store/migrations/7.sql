-- Version 7: windows that were drawn for questions, and what is known of them.
ALTER TABLE items ADD COLUMN window_first INTEGER; -- first time step; null: the one that task and lead give
ALTER TABLE items ADD COLUMN window_last INTEGER;
ALTER TABLE items ADD COLUMN facts TEXT;           -- JSON: critical obstacles, traffic, speed of the ego, tokens
