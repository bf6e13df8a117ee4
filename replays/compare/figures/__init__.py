"""From measured cells to figures: intervals, verdicts, rankings, tables and a summary in words."""
