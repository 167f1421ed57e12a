"""The candidate manoeuvres of a situation, as proposals: what to aim at, and from which guess; a file a kind of manoeuvre."""
