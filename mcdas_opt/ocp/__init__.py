<<<<<<< HEAD
"""Optimal control problems, posed with CasADi."""
=======
"""Optimal control problems as lists of named terms, in CasADi."""
>>>>>>> main
