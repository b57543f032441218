"""The commands of the command line, in groups: one function per command, and its arguments."""
