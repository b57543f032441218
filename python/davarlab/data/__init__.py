"""Recordings: reading, plain operations on signals, what is in a record and is no noise."""
