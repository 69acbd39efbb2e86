"""Claims about the core, each judged by something outside it."""
