"""Diagnoses of bundles whose answers are known: what is found, how far off, how long it takes."""
