"""The tuner: the sigmoid designed as a nonlinear program, its gain schedule, and studies in traffic."""
