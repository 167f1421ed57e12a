"""The rungs of the fallback: one a file, each a small generator of drives that are checked; their order stands in `planning/order.py`."""
