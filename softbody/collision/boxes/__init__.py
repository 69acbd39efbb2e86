"""Contacts of boxes, with each other and with the ground."""
