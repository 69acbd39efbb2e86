"""What does a validation run look like to a person? Makes one page from one record, and computes no physics."""
