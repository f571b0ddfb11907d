-- Version 6: questions about changed scenes, and about windows that end at several times before a collision.
ALTER TABLE items ADD COLUMN lead TEXT;      -- seconds before the collision, or paper; null: that of the whole batch
ALTER TABLE items ADD COLUMN transform TEXT; -- such as mirror or rotate:90; null: the scene as it is
