"""Pages of validation runs for people: one page from one record, without any physics."""
