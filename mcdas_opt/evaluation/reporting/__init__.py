"""What a benchmark found, for people: one document, written as HTML and as Markdown."""
