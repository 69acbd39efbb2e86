"""Independent answers: one file an engine or oracle, plain arrays in and out. Never imports softbody."""
