"""The cloth solver beside others: stretch, cost, cost at equal stretch, growth. `python -m benchmarks.solver`.

Writes `benchmarks/solver.json` and `benchmarks/solver.png`. All figures of a file come from one run. Processor seconds are
counted where one thread works (everything but the processes side by side), so that a neighbour on the machine hardly counts.
"""
