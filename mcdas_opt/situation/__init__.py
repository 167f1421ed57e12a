"""From the facts to what they mean: roles, gaps, threats, and the mode; the paper's Table 1 beside a total selector."""
