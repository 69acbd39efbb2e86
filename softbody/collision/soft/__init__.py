"""Contacts of soft bodies, and the response to them."""
