-- Version 13: requests for better templates (`nearmiss tune`), with their answers. They are about no scenario, so they
-- are no runs and no report counts them.
CREATE TABLE reflections (
    id            INTEGER PRIMARY KEY,
    key           TEXT NOT NULL,    -- SHA-256 of the request
    sample        INTEGER NOT NULL, -- which of several answers to it, from 0
    created_ms    INTEGER NOT NULL, -- milliseconds since 1970, UTC
    model         TEXT NOT NULL,    -- provider/model
    request       TEXT NOT NULL,    -- JSON: messages and parameters
    answer        TEXT,             -- null: it was not answered, or the program was ended before
    finish        TEXT,             -- why the server ended the answer
    error         TEXT,             -- why there is no answer
    input_tokens  INTEGER,
    output_tokens INTEGER,
    cost_usd      REAL,             -- null: unknown
    most_usd      REAL              -- what it can cost at most
) STRICT;
CREATE INDEX reflections_by_key ON reflections (key, sample) WHERE answer IS NOT NULL;
