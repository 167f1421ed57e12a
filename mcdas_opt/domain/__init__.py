"""Nouns that cross a stage: frozen, keyword-only, SI, ISO 8855, numpy only. Import them from their own modules."""
