"""Other people's logs: what sensors they hold, and one of them as samples with exact stamps."""
