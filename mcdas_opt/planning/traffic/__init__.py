"""What a cycle knows of the others: seen from near the host, remembered, and predicted."""
