"""Claims about what users set and ask, files, pictures and messages."""
