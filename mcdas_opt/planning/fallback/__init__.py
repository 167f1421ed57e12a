"""Where a method has no plan: the ladder, and what is least severe where nothing passes."""
