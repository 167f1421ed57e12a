"""Bodies, polygons and the road's frame; numpy only."""
