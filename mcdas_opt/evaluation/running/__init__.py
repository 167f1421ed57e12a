"""Many drives: child processes with a time limit, a pool of them, a Dask cluster, and results that survive a kill."""
