"""The report: contents (what is said), words (how), curves (what is drawn), page (one HTML file).
DESIGN 9."""
