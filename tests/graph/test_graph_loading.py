"""The graph's data are read strictly: a fault is one line that names file, stage and key."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from assets_defs._config import check_configs, resolved_config
from pipeline import GraphError, Home, load_graph
from pipeline.home import PROFILES, REPOSITORY

STAGES = [
    "scan",
    "garment_mesh",
    "scene",
    "reality",
    "recordings",
    "calibrated_physics",
    "mismatch_report",
    "seed_demos",
    "real_demos",
    "segment_pool",
    "motion_model",
    "motion_likeness",
    "candidate_trajectories",
    "state_rules",
    "video_discriminator",
    "valid_trajectories",
    "rendered_episodes",
    "dataset",
    "policy",
    "image_policy",
    "image_trials",
    "scaling_report",
    "ablation_report",
    "cost_report",
]


@pytest.mark.parametrize("profile", PROFILES)
def test_every_profile_of_the_project_loads_with_valid_settings(profile):
    graph = load_graph(Home(REPOSITORY), profile)
    check_configs(graph)
    assert {node.stage.name for node in graph.nodes.values()} == set(STAGES)


@pytest.mark.parametrize("profile", PROFILES)
def test_the_discriminator_watches_video_of_the_size_that_candidates_bring(profile):
    nodes = load_graph(Home(REPOSITORY), profile).nodes
    made, watched = (resolved_config(nodes[name]) for name in ("candidate_trajectories", "video_discriminator"))
    assert (watched["frame_width"], watched["frame_height"]) == (made["video_width"], made["video_height"])


def test_the_shipped_garments_each_have_a_scan_and_a_task():
    home = Home(REPOSITORY)
    assert home.garments() == ["polo", "shorts", "towel", "tshirt"]
    for name in home.garments():
        assert any((REPOSITORY / "data" / "scans" / name).iterdir())
        assert (REPOSITORY / "data" / "tasks" / f"{name}.yaml").is_file()


def test_a_variant_has_assets_of_its_own_only_downstream_of_what_it_changes():
    graph = load_graph(Home(REPOSITORY), "study")
    own = {id_ for id_ in graph.nodes if id_.startswith("without_video/")}
    assert own == {f"without_video/{name}" for name in ("valid_trajectories", "rendered_episodes", "dataset", "policy")}
    assert graph.nodes["without_video/valid_trajectories"].needs["candidate_trajectories"] == "candidate_trajectories"
    assert graph.nodes["without_video/dataset"].needs["rendered_episodes"] == "without_video/rendered_episodes"
    assert graph.nodes["ablation_report"].needs["without_video/policy"] == "without_video/policy"


def test_a_variant_ends_where_it_says_and_exists_in_the_profiles_that_it_names():
    graph = load_graph(Home(REPOSITORY), "study")
    own = {id_ for id_ in graph.nodes if id_.startswith("slicing/")}
    motion = ("calibrated_physics", "seed_demos", "segment_pool", "motion_model", "candidate_trajectories")
    filters = ("state_rules", "video_discriminator", "valid_trajectories")
    assert own == {f"slicing/{name}" for name in (*motion, *filters)}
    needs = graph.nodes["ablation_report"].needs
    assert "slicing/valid_trajectories" in needs
    assert "slicing/policy" not in needs
    assert "slicing" not in load_graph(Home(REPOSITORY), "quick").variants


DATA = ("calibrated_physics", "seed_demos", "segment_pool", "motion_model", "candidate_trajectories")


def settings_of(graph, variant, stages=DATA):
    """Settings of the stages that make a variant's candidates, its own and those that it has of the base."""
    nodes = {name: graph.nodes.get(f"{variant}/{name}") or graph.nodes[name] for name in stages}
    return {f"{name}.{key}": value for name, node in nodes.items() for key, value in node.config.items()}


@pytest.mark.parametrize(("generic", "stable"), [("slicing", "slicing_stable"), ("diffusion", "calibrated")])
def test_rows_that_compare_solvers_differ_in_the_solver_alone(generic, stable):
    graph = load_graph(Home(REPOSITORY), "study")
    one, other = settings_of(graph, generic), settings_of(graph, stable)
    assert dict(one.items() - other.items()) == {"candidate_trajectories.solver": "vbd"}
    assert not other.items() - one.items()


def test_no_row_asks_the_generic_solver_for_named_physics():
    graph = load_graph(Home(REPOSITORY), "paper")
    asked = [settings_of(graph, variant) for variant in graph.variants]
    generic = [one for one in asked if one.get("candidate_trajectories.solver") == "vbd"]
    assert len(generic) == 3
    assert {one["calibrated_physics.simulate_with"] for one in generic} == {"baseline"}


@pytest.mark.parametrize("profile", PROFILES)
def test_no_variant_repeats_the_trials_of_demonstrations(profile):
    graph = load_graph(Home(REPOSITORY), profile)
    policies = [node for node in graph.nodes.values() if node.variant and node.stage.name == "policy"]
    assert policies
    for node in policies:
        assert node.config["simulated_sizes"] == node.config["real_sizes"] == []
        assert node.config["evaluate_sizes"] == 1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mesh": {"ned": ["scan"]}}, "stage 'mesh': key 'ned'"),
        ({"mesh": {"needs": ["scna"]}}, "stage 'mesh' needs 'scna', which is not a stage"),
        ({"scan": {"needs": ["model"]}}, "need each other in a loop"),
        ({"mesh": {"version": 0}}, "stage 'mesh': key 'version'"),
        ({"mesh": {"version": "one"}}, "stage 'mesh': key 'version'"),
        ({"mesh": {"run": "no function"}}, "stage 'mesh': key 'run'"),
        ({"mesh": {"needs": ["dataset"]}}, "one garment's change would re-derive every garment"),
        ({"model": {"name": "mesh"}}, "stage 'mesh' is declared twice"),
        ({"dataset": {"needs": ["report"]}}, "loop"),
        ({"dataset": {"sources": {"scans": "data/scans/{garment}"}}}, "source 'data/scans/{garment}'"),
        ({"mesh": {"sources": {"scan": "data/scans/{garment}"}}}, "share the name ['scan']"),
    ],
)
def test_a_fault_in_stages_yaml_is_named(project, change, said):
    project.stages(**change)
    with pytest.raises(GraphError) as error:
        _ = project.graph
    assert said in str(error.value)
    assert "stages.yaml" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_fault_in_a_profile_or_a_variant_is_named(project):
    folder = project.root / "pipeline"
    (folder / "profiles" / "quick.yaml").write_text("mehs: {size: 1}\n")
    with pytest.raises(GraphError, match=r"quick\.yaml: 'mehs' is not a stage"):
        _ = project.graph
    (folder / "profiles" / "quick.yaml").write_text("mesh: 3\n")
    with pytest.raises(GraphError, match=r"stage 'mesh': expected settings"):
        _ = project.graph
    (folder / "profiles" / "quick.yaml").write_text("mesh: {unclosed\n")
    with pytest.raises(GraphError, match=r"quick\.yaml: not YAML"):
        _ = project.graph
    (folder / "profiles" / "quick.yaml").write_text("{}\n")
    (folder / "ablations.yaml").write_text(yaml.safe_dump({"variants": {"fast": {"change": {}}}}))
    with pytest.raises(GraphError, match=r"variant 'fast': expected the keys"):
        _ = project.graph
    for key, value, said in (
        ("until", "modle", "'modle' is not a stage"),
        ("profiles", ["quik"], r"a list of \['quick'\]"),
    ):
        row = {"changes": {"model": {"width": 9}}, key: value}
        (folder / "ablations.yaml").write_text(yaml.safe_dump({"variants": {"fast": row}}))
        with pytest.raises(GraphError, match=f"variant 'fast': {key} .*{said}"):
            _ = project.graph
    with pytest.raises(GraphError, match=r"profile 'quik' does not exist; there are \['quick'\]"):
        load_graph(project.home, "quik")


def test_an_unknown_setting_is_refused_with_stage_and_key():
    graph = load_graph(Home(REPOSITORY), "smoke")
    node = graph.nodes["garment_mesh"]
    broken = type(graph)(
        {"garment_mesh": type(node)(stage=node.stage, variant=None, config={"edge_lenght_m": 1})}, "smoke", ()
    )
    with pytest.raises(GraphError, match=r"stage 'garment_mesh': key 'edge_lenght_m'"):
        check_configs(broken)


@pytest.mark.parametrize(
    ("stage", "how", "what"),
    [
        ("rendered_episodes", {"workers": 3, "threads": 2}, {"samples": 9}),
        ("policy", {"processes": 3}, {"trial_count": 9}),
        ("image_policy", {"workers": 3, "checkpoint_s": 7.0, "processes": 3, "kept_mib": 0}, {"batch": 9}),
        ("image_trials", {"processes": 3}, {"trial_count": 9}),
    ],
)
def test_how_many_processes_do_it_and_how_often_they_save_is_no_part_of_a_recipe(stage, how, what):
    node = load_graph(Home(REPOSITORY), "smoke").nodes[stage]

    def recorded(settings):
        return resolved_config(type(node)(stage=node.stage, variant=None, config={**node.config, **settings}))

    assert recorded(how) == recorded({})
    assert recorded(what) != recorded({})


def test_a_garment_with_a_name_that_is_no_key_is_refused(project):
    project.add_garment("My Towel")
    with pytest.raises(ValueError, match=r"My Towel\.yaml: a garment's name"):
        project.home.garments()


def test_the_stages_of_the_project_are_light_to_import():
    """So that `sim1 status` and `sim1 run` answer at once; every worker imports all of them."""
    modules = sorted({node.stage.run.split(":")[0] for node in load_graph(Home(REPOSITORY), "quick").nodes.values()})
    heavy = "{'numpy', 'scipy', 'pandas', 'matplotlib', 'torch', 'warp', 'newton', 'bpy', 'pymeshlab', 'lerobot'}"
    code = f"import sys, {', '.join(modules)}; print(sorted({heavy} & set(sys.modules)))"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=REPOSITORY, check=True)
    assert answer.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("room", "least", "banned"),
    [("pipeline", 3, ("dagster", "sim1", "assets_defs")), ("sim1", 100, ("dagster", "pipeline", "assets_defs"))],
)
def test_imports_go_one_way(room, least, banned):
    paths = sorted((REPOSITORY / room).rglob("*.py"))
    assert len(paths) >= least
    for path in paths:
        for name in _imports(path):
            assert name.split(".")[0] not in banned, f"{path.relative_to(REPOSITORY)} imports {name}"


def _imports(path: Path) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.append(node.module)
    return found
