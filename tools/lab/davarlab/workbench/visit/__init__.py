"""A visit to the workbench: what lies on the desk, and everything that a page may ask or do."""
