"""A session of the workbench: what is open, and everything that a page may request or do. What it
leaves behind is a session file (../schema.py)."""
