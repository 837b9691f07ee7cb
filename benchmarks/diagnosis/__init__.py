"""The simulator of the diagnosis against bundles whose answers are known."""
