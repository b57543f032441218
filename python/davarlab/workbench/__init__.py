"""The workbench in a browser: compare, see where it fails, add what is missing (DESIGN 16)."""
