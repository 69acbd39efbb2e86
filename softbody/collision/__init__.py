"""Collision of bodies: broad phase, narrow phase, contacts and the impulses that part them. Never imports dynamics."""
