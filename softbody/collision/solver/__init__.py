"""The solver of many contacts of boxes."""
