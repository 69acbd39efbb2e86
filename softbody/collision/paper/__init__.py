"""The paper's own response to contacts, one after the other."""
