-- Version 8: claims of answers about obstacles, counted when the answer was checked; null: it was not.
ALTER TABLE runs ADD COLUMN claims_right INTEGER; -- claims that hold
ALTER TABLE runs ADD COLUMN claims_wrong INTEGER; -- claims that do not
ALTER TABLE runs ADD COLUMN claims_open INTEGER;  -- claims that cannot be decided
ALTER TABLE runs ADD COLUMN claims_check INTEGER; -- version of the check
