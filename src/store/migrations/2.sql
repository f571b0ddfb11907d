-- Version 2: typed tables; keys, samples, origins, claims; text search; the view `answers`.
ALTER TABLE runs RENAME TO runs_1;
ALTER TABLE pieces RENAME TO pieces_1;
DROP INDEX runs_by_scenario;
DROP INDEX pieces_by_run;

-- Runs: one row a question to a judge. Times are milliseconds since 1970, UTC.
CREATE TABLE runs (
    id             INTEGER PRIMARY KEY,
    key            TEXT,              -- SHA-256 of the whole request, see `nearmiss help store`; null where none was sent
    sample         INTEGER NOT NULL DEFAULT 0,  -- which of several answers to the same request, from 0
    batch          TEXT,              -- the batch it belongs to
    origin         TEXT NOT NULL DEFAULT 'asked' CHECK (origin IN ('asked', 'recorded', 'replayed')),
    source         TEXT,              -- the file that a recorded answer was read from
    created_ms     INTEGER NOT NULL,
    updated_ms     INTEGER NOT NULL,
    scenario       TEXT NOT NULL,     -- name
    scenario_hash  TEXT,              -- SHA-256 of the scenario file; null where it was not found
    ego            TEXT NOT NULL,     -- id and where its motion comes from
    task           TEXT NOT NULL,
    frame          TEXT NOT NULL,
    techniques     TEXT NOT NULL,
    window_first   INTEGER,           -- time steps; null where unknown
    window_last    INTEGER,
    model          TEXT NOT NULL,     -- as asked for, provider/model
    model_returned TEXT,              -- as the server named it
    provider       TEXT NOT NULL,
    dialect        TEXT,              -- the protocol spoken; null where nothing was sent
    endpoint       TEXT NOT NULL,     -- provider and address, never a key
    address        TEXT,              -- the address alone, without user, password and query
    template       TEXT NOT NULL,     -- file name
    template_version TEXT,
    template_hash  TEXT NOT NULL,     -- SHA-256 of its text
    messages       TEXT NOT NULL,     -- JSON, exactly as sent
    parameters     TEXT NOT NULL,     -- JSON, exactly as sent
    answer_schema  TEXT,              -- JSON: the shape that was asked of the server
    state          TEXT NOT NULL CHECK (state IN
                   ('running', 'interrupted', 'answered', 'truncated', 'failed', 'cancelled')),
    answer         TEXT NOT NULL DEFAULT '',
    reasoning      TEXT NOT NULL DEFAULT '',
    finish         TEXT,              -- why the model stopped
    verdict        TEXT CHECK (verdict IS NULL OR json_valid(verdict)),  -- null where the answer holds none
    reading        TEXT,              -- how the verdict was read, or why there is none
    error          TEXT,              -- why there is no answer
    input_tokens   INTEGER,
    output_tokens  INTEGER,
    reasoning_tokens INTEGER,
    cached_tokens  INTEGER,
    cost_usd       REAL,              -- null where unknown
    price_source   TEXT,              -- where the cost comes from
    first_chunk_ms INTEGER,           -- from sending to the first piece
    duration_ms    INTEGER,           -- from sending to the end
    notes          TEXT NOT NULL DEFAULT '',
    pinned         INTEGER NOT NULL DEFAULT 0 CHECK (pinned IN (0, 1)),
    deleted_ms     INTEGER,           -- deleted, and can be restored
    -- What the verdict says, for filters and for people.
    dangerous      INTEGER AS (coalesce(json_extract(verdict, '$.collision'),
                                        json_extract(verdict, '$.safety_critical'))),
    justification  TEXT AS (json_extract(verdict, '$.justification'))
) STRICT;

-- Pieces of answers that are still arriving; moved into their run when it ends.
CREATE TABLE pieces (
    id        INTEGER PRIMARY KEY,
    run       INTEGER NOT NULL REFERENCES runs (id) ON DELETE CASCADE,
    reasoning INTEGER NOT NULL,       -- 1 for reasoning, 0 for the answer
    text      TEXT NOT NULL
) STRICT;

-- Running runs whose program was alive a moment ago; it renews its claim while the answer arrives.
CREATE TABLE claims (
    run      INTEGER PRIMARY KEY REFERENCES runs (id) ON DELETE CASCADE,
    until_ms INTEGER NOT NULL
) STRICT;

-- What was running then has no claim, and becomes `interrupted` when the store is opened.
INSERT INTO runs (id, created_ms, updated_ms, scenario, scenario_hash, ego, task, frame, techniques, window_first,
        window_last, model, model_returned, provider, dialect, endpoint, template, template_hash, messages, parameters,
        state, answer, reasoning, finish, verdict, reading, error, input_tokens, output_tokens, reasoning_tokens,
        cached_tokens, cost_usd, price_source, first_chunk_ms, duration_ms)
    SELECT id, created_ms, updated_ms, scenario, scenario_hash, ego, task, frame, techniques, window_first,
        window_last, model, model_returned,
        CASE instr(model, '/') WHEN 0 THEN model ELSE substr(model, 1, instr(model, '/') - 1) END,
        CASE endpoint WHEN 'built in' THEN NULL ELSE 'openai_chat' END,
        endpoint, template, template_hash, messages, parameters,
        CASE WHEN state = 'answered' AND finish IN ('length', 'content_filter') THEN 'truncated'
             WHEN state IN ('running', 'answered', 'failed', 'cancelled') THEN state ELSE 'failed' END,
        answer, reasoning, finish, CASE WHEN json_valid(verdict) THEN verdict END, reading, error, input_tokens,
        output_tokens, reasoning_tokens, cached_tokens, cost_usd,
        CASE WHEN cost_usd IS NOT NULL THEN 'stated by the server' END, first_chunk_ms, duration_ms
    FROM runs_1;
INSERT INTO pieces (id, run, reasoning, text) SELECT id, run, reasoning, text FROM pieces_1;
DROP TABLE pieces_1;
DROP TABLE runs_1;

CREATE INDEX runs_by_key ON runs (key, sample, created_ms) WHERE key IS NOT NULL;
CREATE INDEX runs_by_time ON runs (created_ms, id);
CREATE INDEX runs_by_scenario ON runs (scenario_hash, task, created_ms);
CREATE INDEX runs_by_name ON runs (scenario, task, created_ms);
CREATE INDEX runs_running ON runs (id) WHERE state = 'running';
CREATE INDEX pieces_by_run ON pieces (run, id);

-- Words of answers: SELECT rowid FROM runs_text WHERE runs_text MATCH 'brakes';
CREATE VIRTUAL TABLE runs_text USING fts5 (scenario, answer, reasoning, justification, notes,
    content = 'runs', content_rowid = 'id', tokenize = 'unicode61');
INSERT INTO runs_text (runs_text) VALUES ('rebuild');
CREATE TRIGGER runs_text_insert AFTER INSERT ON runs BEGIN
    INSERT INTO runs_text (rowid, scenario, answer, reasoning, justification, notes)
        VALUES (new.id, new.scenario, new.answer, new.reasoning, new.justification, new.notes);
END;
CREATE TRIGGER runs_text_delete AFTER DELETE ON runs BEGIN
    INSERT INTO runs_text (runs_text, rowid, scenario, answer, reasoning, justification, notes)
        VALUES ('delete', old.id, old.scenario, old.answer, old.reasoning, old.justification, old.notes);
END;
CREATE TRIGGER runs_text_update AFTER UPDATE OF scenario, answer, reasoning, verdict, notes ON runs BEGIN
    INSERT INTO runs_text (runs_text, rowid, scenario, answer, reasoning, justification, notes)
        VALUES ('delete', old.id, old.scenario, old.answer, old.reasoning, old.justification, old.notes);
    INSERT INTO runs_text (rowid, scenario, answer, reasoning, justification, notes)
        VALUES (new.id, new.scenario, new.answer, new.reasoning, new.justification, new.notes);
END;

-- For people: one line an answer, the newest first.
CREATE VIEW answers AS
    SELECT id AS run, datetime(created_ms / 1000, 'unixepoch') AS asked_at_utc, origin, scenario, task, frame,
        techniques, window_first AS first_step, window_last AS last_step, model, model_returned AS answered_by, sample,
        state, CASE dangerous WHEN 1 THEN 'yes' WHEN 0 THEN 'no' END AS dangerous, justification, verdict, reading,
        answer, reasoning, error AS problem, input_tokens, output_tokens, cost_usd, duration_ms / 1000.0 AS seconds,
        notes
    FROM runs WHERE deleted_ms IS NULL ORDER BY created_ms DESC, id DESC;
