"""The rounds of the search: one a file, each a small generator; their order stands in `planning/order.py`."""
