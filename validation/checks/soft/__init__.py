"""Claims about soft bodies: gas, springs, contacts."""
