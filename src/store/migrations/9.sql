-- Version 9: axes of batches, and splits of their scenarios into dev and test.
ALTER TABLE items ADD COLUMN settings TEXT; -- values of axes, such as effort low, temperature 0.7; null: those of the whole batch
ALTER TABLE items ADD COLUMN split TEXT CHECK (split IN ('dev', 'test')); -- null: the batch has no split

-- Looks at the figures of a test split before it was complete.
CREATE TABLE looks (
    batch     INTEGER NOT NULL REFERENCES batches (id) ON DELETE CASCADE,
    at_ms     INTEGER NOT NULL,      -- milliseconds since 1970, UTC
    answered  INTEGER NOT NULL,      -- answers of the test split that were there
    questions INTEGER NOT NULL       -- its questions
) STRICT;
CREATE INDEX looks_by_batch ON looks (batch);
CREATE INDEX items_by_split ON items (batch, split) WHERE split IS NOT NULL;
