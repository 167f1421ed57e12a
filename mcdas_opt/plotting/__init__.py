"""Figures and animations: returned, never shown; no pyplot state. Colour-blind safe, units on every axis."""
