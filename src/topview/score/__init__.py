"""The top view re-projection scores and their factors; `definition` is where to start reading."""
