"""The particle filter, filters over time, and the assignment of rows to columns; it knows no
bodies."""
