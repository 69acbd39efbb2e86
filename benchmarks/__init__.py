"""What the pieces cost, measured by pytest-benchmark."""
