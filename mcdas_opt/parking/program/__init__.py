"""The nonlinear program of parking, the manoeuvres that it starts from, and the loop that adds its collision checks."""
