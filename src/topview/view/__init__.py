"""Pictures of what was tracked."""
