-- Version 5: batches that are with a provider: written down before anything is sent, so that none is paid for twice.
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
