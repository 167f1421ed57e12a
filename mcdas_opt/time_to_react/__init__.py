"""Time to react: until when each candidate manoeuvre can still be started (the escape map), and the alert that follows from it."""
