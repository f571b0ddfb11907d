-- Version 3: the runs that are not deleted, in the order of lists, without reading their texts.
CREATE INDEX runs_listed ON runs (created_ms, id) WHERE deleted_ms IS NULL;
