"""Version of softbody."""

__version__ = "0.1.0"
