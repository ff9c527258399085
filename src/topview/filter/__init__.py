"""The particle filter; it knows no bodies."""
