-- The decision of a verdict is also that of the recording task. Values of generated columns are not stored, so nothing
-- is rewritten.
DROP VIEW answers;
ALTER TABLE runs DROP COLUMN dangerous;
ALTER TABLE runs ADD COLUMN dangerous INTEGER
    AS (coalesce(json_extract(verdict, '$.collision'), json_extract(verdict, '$.safety_critical'),
                 json_extract(verdict, '$.high_risk')));

-- For people, with numbers to count with: is_dangerous is 1, 0 or null.
CREATE VIEW answers AS
    SELECT id AS run, datetime(created_ms / 1000, 'unixepoch') AS asked_at_utc, origin, scenario, task, frame,
        techniques, window_first AS first_step, window_last AS last_step, model, model_returned AS answered_by, sample,
        state, CASE dangerous WHEN 1 THEN 'yes' WHEN 0 THEN 'no' END AS dangerous, dangerous AS is_dangerous,
        justification, verdict, reading, answer, reasoning, error AS problem, input_tokens, output_tokens, cost_usd,
        most_usd, duration_ms / 1000.0 AS seconds, notes
    FROM runs WHERE deleted_ms IS NULL ORDER BY created_ms DESC, id DESC;
