-- Rounds of tool calls of a run: a JSON array, kept round by round, so that a question that breaks off goes on after the
-- rounds that are paid.
ALTER TABLE runs ADD COLUMN tool_rounds TEXT;
