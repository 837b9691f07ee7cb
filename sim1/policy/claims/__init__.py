"""What the paper claims, beside what a run measured, and whether the one holds by the other."""
