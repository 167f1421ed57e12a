"""The judge: re-integration, limits, swept bodies, road. Imports no solver and no CasADi."""
