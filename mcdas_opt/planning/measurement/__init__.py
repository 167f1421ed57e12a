"""From what is measured to the situation that a cycle plans in: the host's state that is believed, and tracks."""
