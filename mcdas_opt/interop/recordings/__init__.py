"""Recordings, whatever file they are in: CAN frames and tables of numbers, behind one interface."""
