-- Runs: one row a question to a judge. Times are milliseconds since 1970, UTC.
CREATE TABLE runs (
    id             INTEGER PRIMARY KEY,
    created_ms     INTEGER NOT NULL,
    updated_ms     INTEGER NOT NULL,
    scenario       TEXT NOT NULL,     -- name
    scenario_hash  TEXT NOT NULL,     -- SHA-256 of the scenario file
    ego            TEXT NOT NULL,     -- id and where its motion comes from
    task           TEXT NOT NULL,
    frame          TEXT NOT NULL,
    techniques     TEXT NOT NULL,
    window_first   INTEGER NOT NULL,  -- time steps
    window_last    INTEGER NOT NULL,
    model          TEXT NOT NULL,     -- as asked for, provider/model
    model_returned TEXT,              -- as the server named it
    endpoint       TEXT NOT NULL,     -- address, never a key
    template       TEXT NOT NULL,     -- file name
    template_hash  TEXT NOT NULL,     -- SHA-256 of its text
    messages       TEXT NOT NULL,     -- JSON, exactly as sent
    parameters     TEXT NOT NULL,     -- JSON, exactly as sent
    state          TEXT NOT NULL,     -- running, answered, failed, cancelled
    answer         TEXT NOT NULL DEFAULT '',
    reasoning      TEXT NOT NULL DEFAULT '',
    finish         TEXT,              -- why the model stopped
    verdict        TEXT,              -- JSON; null where the answer holds none
    reading        TEXT,              -- how the verdict was read, or why there is none
    error          TEXT,              -- why there is no answer
    input_tokens   INTEGER,
    output_tokens  INTEGER,
    reasoning_tokens INTEGER,
    cached_tokens  INTEGER,
    cost_usd       REAL,              -- as stated by the server; null where unknown
    first_chunk_ms INTEGER,           -- from sending to the first piece
    duration_ms    INTEGER            -- from sending to the end
);
CREATE INDEX runs_by_scenario ON runs (scenario_hash, task, id);

-- Pieces of answers that are still arriving; moved into their run when it ends.
CREATE TABLE pieces (
    id        INTEGER PRIMARY KEY,
    run       INTEGER NOT NULL REFERENCES runs (id) ON DELETE CASCADE,
    reasoning INTEGER NOT NULL,       -- 1 for reasoning, 0 for the answer
    text      TEXT NOT NULL
);
CREATE INDEX pieces_by_run ON pieces (run, id);
