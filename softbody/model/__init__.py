"""What a world is made of: arrays, settings, materials, and the checks of what users give."""
