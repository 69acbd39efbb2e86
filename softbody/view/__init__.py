"""A world that is watched and steered while it moves, live in the browser: `World.view`, `python -m softbody view`.

What is not the browser's needs none: `session` (the loop that moves the world), `adjustments` (what a slider changes),
`grip` (how a body is pulled), `frame` (what is shown). `page` has the controls, and `serving` brings both together.
"""
