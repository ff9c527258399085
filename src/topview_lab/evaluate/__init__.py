"""Metrics with units, and the data sets they are measured on."""
