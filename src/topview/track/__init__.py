"""The frame recipe and the full-body tracker."""
