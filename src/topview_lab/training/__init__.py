"""Train the detectors' tables and the forest, on labelled recordings or on the simulator."""
