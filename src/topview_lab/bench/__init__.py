"""Timing the tracker on this machine: whole frames, single stages and inner loops."""
