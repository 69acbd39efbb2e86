"""Claims about meshes, points in them, and shapes that meet."""
