"""The top view re-projection scores and their factors."""
