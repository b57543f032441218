"""Which effect is missing: candidates, the search, the judge's words in figures."""
