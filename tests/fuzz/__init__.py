"""What `make fuzz` tries, a campaign a module; see `tests/fuzz/__main__.py`."""
