"""Every engine beside every other: how right its answers are, and what they cost it."""
