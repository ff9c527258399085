"""One reader per recording format."""
