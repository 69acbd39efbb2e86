"""Closed triangle meshes: made, read, welded and diagnosed."""
