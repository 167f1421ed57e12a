"""The judges: they share with the planners nothing but records, geometry and the equations."""
