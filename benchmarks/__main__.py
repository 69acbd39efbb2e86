"""`python -m benchmarks`: measure, compare, calibrate, look back."""

from benchmarks.cli import main

if __name__ == "__main__":
    main()
