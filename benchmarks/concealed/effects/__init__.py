"""What can be concealed, one family a file. The registry is `benchmarks.concealed.effects.library`."""
