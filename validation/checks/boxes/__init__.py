"""Claims about rigid boxes: impacts, contacts, piles."""
