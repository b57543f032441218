"""Tables in text files: how they are written, and what their columns are."""
