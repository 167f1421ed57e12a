"""ESR frames from a CAN bus in, a judged plan a cycle out."""
