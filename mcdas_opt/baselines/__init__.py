"""The planners that ours is compared with: the paper's closed form (literal, corrected, tuned), and what others do. One a file."""
