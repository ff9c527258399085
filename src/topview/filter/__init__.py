"""The particle filter, and filters over time; it knows no bodies."""
