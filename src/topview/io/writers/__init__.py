"""One writer per skeleton format."""
