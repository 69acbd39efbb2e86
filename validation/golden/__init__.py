"""What softbody wrote and computed at known revisions, kept to be compared with."""
