"""What a world is at one instant, in memory and in files."""
