"""Claims, one family a file."""
