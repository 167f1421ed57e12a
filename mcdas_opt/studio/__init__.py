"""The studio: a page on 127.0.0.1 in which a sandwich answers while a slider moves, and a car parks where its slot is dragged to."""
