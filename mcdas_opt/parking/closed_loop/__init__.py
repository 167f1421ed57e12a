"""A parking manoeuvre driven: tracking, a noisy pose, what the car sees, and a judged stop in every cycle."""
