"""Is a fan-in over 150 garments fresh? Two queries per asset against one query per parent."""

import tempfile
from pathlib import Path
from typing import Any

import dagster as dg
from dagster import DagsterEventType

from benchmarks.timing import against

COUNT = 150


def compare() -> dict[str, Any]:
    """Reading the data versions of 150 partitions from the event log."""
    with tempfile.TemporaryDirectory() as folder, dg.DagsterInstance.local_temp(str(Path(folder))) as instance:
        key = dg.AssetKey("parent")
        names = [f"g{number:03}" for number in range(COUNT)]
        for name in names:
            tags = {"dagster/data_version": name}
            instance.report_runless_asset_event(dg.AssetMaterialization(key, partition=name, tags=tags))

        def together() -> None:
            storage = instance.event_log_storage
            ids = storage.get_latest_storage_id_by_partition(key, DagsterEventType.ASSET_MATERIALIZATION)
            wanted = dg.AssetRecordsFilter(asset_key=key, storage_ids=list(ids.values()))
            records = instance.fetch_materializations(wanted, limit=COUNT).records
            assert len(records) == COUNT

        def one_by_one() -> None:
            for name in names:
                wanted = dg.AssetRecordsFilter(asset_key=key, asset_partitions=[name])
                assert instance.fetch_materializations(wanted, limit=1).records

        return against(
            f"data versions of {COUNT} parents, two queries", together, "the same, one query per parent", one_by_one
        )
