"""One step of a world, and what is checked before and after it."""
