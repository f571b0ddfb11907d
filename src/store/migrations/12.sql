-- Images that questions showed, by the hash that their messages name them by: each once, however often it was asked with.
CREATE TABLE images (
    sha256 TEXT NOT NULL PRIMARY KEY,
    media_type TEXT NOT NULL,
    width INTEGER NOT NULL,
    height INTEGER NOT NULL,
    bytes BLOB NOT NULL
) WITHOUT ROWID;
