"""Parking: the case, the search, the nonlinear program, the closed forms, and the drive in closed loop. Begin with `park.park`."""
