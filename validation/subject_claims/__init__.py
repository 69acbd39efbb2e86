"""Claims about anybody who moves boxes, holds gas, or tells inside from outside. One kind of question a file.

Tolerances are those of the same claims about the core, in double precision, and are not widened for anybody: what an
engine misses by is its result. Expected values are closed forms, invariants or exact, and never a subject's.
"""
