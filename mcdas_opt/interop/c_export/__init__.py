"""The MPC step as C99: generated solver, a clean header, and a program that replays what Python recorded."""
