"""Many recordings against one model on Dask: a table, and a page of the population."""
