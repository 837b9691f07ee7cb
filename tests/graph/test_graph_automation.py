"""Automation follows the recipe: level-triggered, parents first, failed recipes left alone."""

import dagster as dg
import pytest

from assets_defs.definitions import bind_all, definitions


@pytest.fixture
def location(made):
    """The code location of the toy project, everything made."""
    return definitions(made.graph, made.home)


def requested(location, instance, cursor=None):
    result = dg.evaluate_automation_conditions(
        location, instance=instance, asset_selection=dg.AssetSelection.all(), cursor=cursor
    )
    found = []
    for row in result.results:
        for one in row.true_subset.expensively_compute_asset_partitions():
            found.append("/".join(filter(None, [one.asset_key.to_user_string(), one.partition_key])))
    return sorted(found), result.cursor


def test_the_condition_asks_for_what_changed_and_lets_the_rest_wait(location, made):
    with made.instance() as instance:
        found, cursor = requested(location, instance)
        assert found == []
        made.add_garment("towel", "point 4 4 4")
        found, cursor = requested(location, instance, cursor)
        assert found == ["scan/towel"]
        # Level-triggered: still true at the next look, as nothing was made yet.
        found, cursor = requested(location, instance, cursor)
        assert found == ["scan/towel"]
    made.run(nodes={"scan"})
    with made.instance() as instance:
        assert requested(location, instance)[0] == ["mesh/towel"]


def test_a_recipe_that_failed_is_not_asked_for_again(location, made):
    made.add_garment("towel", "bad")
    made.run()
    with made.instance() as instance:
        assert requested(location, instance)[0] == []
        made.add_garment("towel", "point 5 5 5")
        assert requested(location, instance)[0] == ["scan/towel"]


def test_a_garment_file_that_appears_becomes_a_partition_and_one_that_goes_leaves(location, made):
    sensor = location.resolve_sensor_def("garments_on_disk")
    with made.instance() as instance:
        context = dg.build_sensor_context(instance=instance)
        assert isinstance(sensor(context), dg.SkipReason)
        made.add_garment("shorts")
        (made.root / "data" / "garments" / "shirt.yaml").unlink()
        changes = sensor(context).dynamic_partitions_requests
        assert sorted((type(change).__name__, *change.partition_keys) for change in changes) == [
            ("AddDynamicPartitionsRequest", "shorts"),
            ("DeleteDynamicPartitionsRequest", "shirt"),
        ]


def test_the_nightly_job_makes_what_is_stale(location, made):
    made.add_garment("towel", "point 6 6 6")
    before = made.events()
    job = location.resolve_job_def("regenerate_all")
    with made.instance() as instance:
        assert job.execute_in_process(instance=instance).success
    assert made.events()[len(before) :] == ["scan/towel", "mesh/towel", "model/towel", "dataset", "report"]
    assert location.resolve_schedule_def("nightly").cron_schedule == "0 2 * * *"


def test_materializing_from_the_ui_records_recipe_and_lineage(location, made):
    made.add_garment("towel", "point 8 8 8")
    job = location.resolve_implicit_global_asset_job_def()
    with made.instance() as instance:
        result = job.execute_in_process(
            instance=instance, partition_key="towel", asset_selection=[dg.AssetKey("scan"), dg.AssetKey("mesh")]
        )
        assert result.success
        checks = result.get_asset_check_evaluations()
        assert [check.passed for check in checks] == [True]
    assert sorted(made.run().made) == ["dataset", "model/towel", "report"]


def test_assets_have_the_pools_of_their_stages_which_let_one_in_at_a_time(made):
    made.stages(mesh={"pool": "x"}, report={"pool": "y"})
    pools = {name: asset.op.pool for name, asset in bind_all(made.graph, made.home).items()}
    assert pools == {"scan": None, "mesh": "x", "model": None, "dataset": None, "report": "y"}
    with made.instance() as instance:
        limits = instance.get_concurrency_config().pool_config
        assert (limits.default_pool_limit, limits.pool_granularity.value) == (1, "op")
