"""Handles of what is in a world, and how bodies are added and removed."""
