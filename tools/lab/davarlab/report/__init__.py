"""The report: contents (what is said), words (how), pictures, page (HTML, one file). DESIGN 9."""
