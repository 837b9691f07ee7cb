"""How Dagster sees the pipeline: one factory turns each stage into an asset with lineage. `definitions` holds the result."""
