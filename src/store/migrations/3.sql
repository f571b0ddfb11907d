-- Version 3: a quick order of lists, ratings, and what runs can have cost.

-- The runs that are not deleted, in the order of lists, without reading their texts.
CREATE INDEX runs_listed ON runs (created_ms, id) WHERE deleted_ms IS NULL;

-- What a person made of answers side by side.
CREATE TABLE ratings (
    id         INTEGER PRIMARY KEY,
    created_ms INTEGER NOT NULL,      -- milliseconds since 1970, UTC
    person     TEXT NOT NULL,         -- who rated: `person` of the configuration, else the user's name
    scenario   TEXT NOT NULL,         -- name
    task       TEXT NOT NULL,
    blind      INTEGER NOT NULL CHECK (blind IN (0, 1)),  -- 1 where models were hidden and the order shuffled
    seed       INTEGER NOT NULL,      -- of the shuffled order
    choice     TEXT NOT NULL CHECK (choice IN ('best', 'tie', 'none')),  -- none: all of them are wrong
    notes      TEXT NOT NULL DEFAULT ''
) STRICT;

-- The answers of a rating in the order in which they were shown.
CREATE TABLE rated (
    rating INTEGER NOT NULL REFERENCES ratings (id) ON DELETE CASCADE,
    place  INTEGER NOT NULL,          -- from the left, from 0
    run    INTEGER REFERENCES runs (id) ON DELETE SET NULL,  -- null where the answer is in no run
    model  TEXT NOT NULL,             -- as asked for, provider/model
    prompt TEXT NOT NULL,             -- how it was asked: frame and techniques
    best   INTEGER NOT NULL CHECK (best IN (0, 1)),
    wrong  INTEGER NOT NULL CHECK (wrong IN (0, 1)),       -- marked as wrong
    reason TEXT,                      -- why it is wrong
    PRIMARY KEY (rating, place)
) STRICT, WITHOUT ROWID;
CREATE INDEX rated_by_run ON rated (run) WHERE run IS NOT NULL;

-- The most that a run can have cost, from estimated tokens and the limit of the answer: known before it is asked, so that
-- it is there for runs that broke off. Null where there is no price or no limit; 0 where nothing was sent.
ALTER TABLE runs ADD COLUMN most_usd REAL;

-- For people, with numbers to count with: is_dangerous is 1, 0 or null.
DROP VIEW answers;
CREATE VIEW answers AS
    SELECT id AS run, datetime(created_ms / 1000, 'unixepoch') AS asked_at_utc, origin, scenario, task, frame,
        techniques, window_first AS first_step, window_last AS last_step, model, model_returned AS answered_by, sample,
        state, CASE dangerous WHEN 1 THEN 'yes' WHEN 0 THEN 'no' END AS dangerous, dangerous AS is_dangerous,
        justification, verdict, reading, answer, reasoning, error AS problem, input_tokens, output_tokens, cost_usd,
        most_usd, duration_ms / 1000.0 AS seconds, notes
    FROM runs WHERE deleted_ms IS NULL ORDER BY created_ms DESC, id DESC;
