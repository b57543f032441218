"""A session of the workbench: what is open, and everything that a page may ask or do."""
