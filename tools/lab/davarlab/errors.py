"""What a person did wrong, in one line."""


class BadInput(Exception):
    """A file, line, column or option that cannot be used; the command line prints it and exits with status 2."""
