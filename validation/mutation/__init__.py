"""How many small faults of the core do the claims see? Mutants of its syntax tree, judged by the thousand."""
