"""Where the detectors' tables are learnt, from labelled recordings or from the simulator."""
