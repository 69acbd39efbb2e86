"""Vectors, quaternions, and vectors in lanes."""
