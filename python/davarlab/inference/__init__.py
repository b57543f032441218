"""The likelihood of a model on one recording: its maximum, intervals, what is left over."""
