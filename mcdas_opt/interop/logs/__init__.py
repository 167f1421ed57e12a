"""A drive as a log for others' viewers: MCAP for Foxglove, .rrd for Rerun."""
