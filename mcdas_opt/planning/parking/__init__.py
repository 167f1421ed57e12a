"""Parking: search, closed forms, the nonlinear program with its exchange loop, and the one public function `park`."""
