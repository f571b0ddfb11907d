-- Version 4: batches, questions asked in bulk: what shall be asked is written down before anything is sent.

-- A batch; people call it b and its number.
CREATE TABLE batches (
    id         INTEGER PRIMARY KEY,
    created_ms INTEGER NOT NULL,      -- milliseconds since 1970, UTC
    updated_ms INTEGER NOT NULL,      -- when something was last added to it
    spec       TEXT NOT NULL,         -- JSON: paths, matrix, settings, where the truth is from, hashes of the templates
    shard      TEXT                   -- the parts of it that are here, such as 1/4 or 1/4,3/4; null where it is whole
) STRICT;

-- Its questions: a scenario, a way of asking, a sample.
CREATE TABLE items (
    batch      INTEGER NOT NULL REFERENCES batches (id) ON DELETE CASCADE,
    place      INTEGER NOT NULL,      -- the order in which they are asked, from 0
    path       TEXT NOT NULL,         -- the scenario's file, or the name of a bundled one
    scenario   TEXT NOT NULL,         -- its name
    scenario_hash TEXT,               -- SHA-256 of its file; null where it could not be read
    ego        TEXT,                  -- null where it could not be read
    task       TEXT NOT NULL,
    frame      TEXT,                  -- null of a judge that is not asked in words
    techniques TEXT,                  -- the same
    model      TEXT NOT NULL,         -- provider/model
    sample     INTEGER NOT NULL,      -- which of several answers to the same request, from 0
    key        TEXT,                  -- of the request, as in runs; null where none is sent
    collides   INTEGER CHECK (collides IN (0, 1)),  -- what is true; null where nobody says
    obstacle   INTEGER,               -- who collides with the ego, where the truth says so
    state      TEXT NOT NULL CHECK (state IN ('waiting', 'answered', 'truncated', 'failed', 'unaskable')),
    run        INTEGER REFERENCES runs (id) ON DELETE SET NULL,  -- the last run that was made for it
    error      TEXT,                  -- why there is no whole answer, or why it was not asked
    PRIMARY KEY (batch, place)
) STRICT, WITHOUT ROWID;
CREATE INDEX items_by_run ON items (run) WHERE run IS NOT NULL;
