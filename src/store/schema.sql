-- The tables of the store, version 13. Times are milliseconds since 1970, UTC.

-- Runs: one row a question to a judge.
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
    justification  TEXT AS (json_extract(verdict, '$.justification')),
    -- The most that it can have cost, from estimated tokens and the limit of the answer: known before it is asked, so
    -- that it is there for runs that broke off. Null where there is no price or no limit; 0 where nothing was sent.
    most_usd       REAL,
    -- Claims of the answer about obstacles, counted when it was checked; null: it was not.
    claims_right   INTEGER,           -- claims that hold
    claims_wrong   INTEGER,           -- claims that do not
    claims_open    INTEGER,           -- claims that cannot be decided
    claims_check   INTEGER,           -- version of the check
    -- The decision of the verdict.
    dangerous      INTEGER AS (coalesce(json_extract(verdict, '$.collision'),
                                        json_extract(verdict, '$.safety_critical'),
                                        json_extract(verdict, '$.high_risk'))),
    -- Rounds of tool calls: a JSON array, kept round by round, so that a question that breaks off goes on after the
    -- rounds that are paid.
    tool_rounds    TEXT,
    claims_invented          INTEGER, -- wrong numbers that the question does not have; null also where that is not known
    -- Sentences of the answer that say something of the scene, counted with its claims.
    sentences                INTEGER,
    sentences_not_understood INTEGER,
    sentences_contradictory  INTEGER  -- those that contradict another one
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

CREATE INDEX runs_by_key ON runs (key, sample, created_ms) WHERE key IS NOT NULL;
CREATE INDEX runs_by_time ON runs (created_ms, id);
CREATE INDEX runs_by_scenario ON runs (scenario_hash, task, created_ms);
CREATE INDEX runs_by_name ON runs (scenario, task, created_ms);
CREATE INDEX runs_running ON runs (id) WHERE state = 'running';
CREATE INDEX pieces_by_run ON pieces (run, id);

-- Words of answers: SELECT rowid FROM runs_text WHERE runs_text MATCH 'brakes';
CREATE VIRTUAL TABLE runs_text USING fts5 (scenario, answer, reasoning, justification, notes,
    content = 'runs', content_rowid = 'id', tokenize = 'unicode61');
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
    lead       TEXT,                  -- seconds before the collision, or paper; null: that of the whole batch
    transform  TEXT,                  -- such as mirror or rotate:90; null: the scene as it is
    window_first INTEGER,             -- first time step; null: the one that task and lead give
    window_last INTEGER,
    facts      TEXT,                  -- JSON: critical obstacles, traffic, speed of the ego, tokens
    settings   TEXT,                  -- values of axes, such as effort low; null: those of the whole batch
    split      TEXT CHECK (split IN ('dev', 'test')),  -- null: the batch has no split
    PRIMARY KEY (batch, place)
) STRICT, WITHOUT ROWID;
CREATE INDEX items_by_run ON items (run) WHERE run IS NOT NULL;
CREATE INDEX items_by_split ON items (batch, split) WHERE split IS NOT NULL;

-- Batches that are with a provider: written down before anything is sent, so that none is paid for twice.
CREATE TABLE provider_batches (
    id           INTEGER PRIMARY KEY,
    tag          TEXT NOT NULL UNIQUE, -- sent along, so that the batch is recognised where its id did not arrive
    created_ms   INTEGER NOT NULL,     -- milliseconds since 1970, UTC
    updated_ms   INTEGER NOT NULL,
    submitted_ms INTEGER NOT NULL,     -- when it was about to be sent
    model        TEXT NOT NULL,        -- provider/model
    address      TEXT NOT NULL,        -- of the server, without user, password and query
    remote_id    TEXT,                 -- the provider's id; null until it arrived
    state        TEXT NOT NULL CHECK (state IN
                 ('submitting', 'submitted', 'cancelling', 'ended', 'cancelled', 'expired', 'failed', 'not_sent')),
    problem      TEXT                  -- why it has no answers
) STRICT;

-- The questions of a batch. Their runs are `running`, and claimed for as long as the batch is with the provider.
CREATE TABLE provider_requests (
    run       INTEGER PRIMARY KEY REFERENCES runs (id) ON DELETE CASCADE,
    batch     INTEGER NOT NULL REFERENCES provider_batches (id) ON DELETE CASCADE,
    custom_id TEXT NOT NULL,           -- what the provider calls it
    done      INTEGER NOT NULL DEFAULT 0 CHECK (done IN (0, 1)),  -- 1 once its result is in the run
    UNIQUE (batch, custom_id)
) STRICT;

-- Looks at the figures of a test split before it was complete.
CREATE TABLE looks (
    batch     INTEGER NOT NULL REFERENCES batches (id) ON DELETE CASCADE,
    at_ms     INTEGER NOT NULL,      -- milliseconds since 1970, UTC
    answered  INTEGER NOT NULL,      -- answers of the test split that were there
    questions INTEGER NOT NULL       -- its questions
) STRICT;
CREATE INDEX looks_by_batch ON looks (batch);

-- Images that questions showed, by the hash that their messages name them by: each once, however often it was asked with.
CREATE TABLE images (
    sha256 TEXT NOT NULL PRIMARY KEY,
    media_type TEXT NOT NULL,
    width INTEGER NOT NULL,
    height INTEGER NOT NULL,
    bytes BLOB NOT NULL
) WITHOUT ROWID;

-- Requests for better templates (`nearmiss tune`), with their answers. They are about no scenario, so they
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

-- For people, with numbers to count with: is_dangerous is 1, 0 or null.
CREATE VIEW answers AS
    SELECT id AS run, datetime(created_ms / 1000, 'unixepoch') AS asked_at_utc, origin, scenario, task, frame,
        techniques, window_first AS first_step, window_last AS last_step, model, model_returned AS answered_by, sample,
        state, CASE dangerous WHEN 1 THEN 'yes' WHEN 0 THEN 'no' END AS dangerous, dangerous AS is_dangerous,
        justification, verdict, reading, answer, reasoning, error AS problem, input_tokens, output_tokens, cost_usd,
        most_usd, duration_ms / 1000.0 AS seconds, notes
    FROM runs WHERE deleted_ms IS NULL ORDER BY created_ms DESC, id DESC;
