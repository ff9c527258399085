"""Other ways to track a body, to compare with: particle swarms, a decision forest, ellipsoids."""
