"""Parking: the case, the search, the nonlinear program, the closed forms, and the drive in closed loop. `park.park` is the way in."""
