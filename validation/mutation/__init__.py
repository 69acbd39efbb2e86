"""Mutation testing of the core: mutants of its syntax tree, judged by the claims by the thousand."""
