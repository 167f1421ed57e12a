"""The sampled family of manoeuvres, scored against predicted bodies in one vectorised pass; what is still open, and until when."""
