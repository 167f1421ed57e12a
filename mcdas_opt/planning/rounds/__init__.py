"""The rounds of the search and the rungs of the fallback: one a file, each a small generator; their order stands in `planning/order.py`."""
