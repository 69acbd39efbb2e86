"""Which bodies touch, where, and what impulse parts them? Never imports dynamics."""
