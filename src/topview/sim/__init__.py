"""The simulator: people, motions, rooms and a depth sensor, rendered its own way."""
