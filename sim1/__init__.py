"""From a garment scan and a few demonstrations to a robot-learning dataset. The work itself; see `docs/artifacts.md`."""
