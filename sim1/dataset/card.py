"""The dataset's card: what is in it, where it comes from, and what in it stands in for reality."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from jinja2 import Environment

from sim1.dataset.keypoints import KEYPOINTS
from sim1.dataset.pictures import write_frames_picture, write_motion_picture
from sim1.render.appearance import SCANNED
from sim1.stage import BadInput, Facts

FILE = "README.md"
CARD = """\
---
license: {{ licenses[0] if licenses|length == 1 else "[" ~ licenses|join(", ") ~ "]" }}
task_categories:
- robotics
tags:
- LeRobot
- deformable
- simulation
configs:
- config_name: default
  data_files: lerobot/data/*/*.parquet
---

# Garment folding with two arms, simulated

{{ total.episodes }} episodes, {{ total.frames }} frames at {{ info.fps }} Hz ({{ "%.1f"|format(total.minutes) }} minutes,
{{ "%.1f"|format(total.size_mb) }} MB) of {{ table|length }} garment{{ "s" if table|length != 1 }}, in the
[LeRobot](https://github.com/huggingface/lerobot) format {{ info.codebase_version }}. License: {{ licenses|join(", ") }}
{%- if "unknown" in licenses %} (whoever owns the data names it in `data/dataset.yaml`, key `license`){% endif %}.

![Frames of every garment from first to last](frames.png)

| garment | task | trajectories | appearances each | episodes | frames | mean length (s) |
| --- | --- | ---: | ---: | ---: | ---: | ---: |
{% for row in table -%}
| {{ row.garment }} | {{ row.task }} | {{ row.trajectories }} | {{ "%.1f"|format(row.episodes / row.trajectories) }} | {{ row.episodes }} | {{ row.frames }} | {{ "%.1f"|format(row.mean_s) }} |
{% endfor %}
## What stands in for reality

None of the figures or pictures here were measured on a real robot.

* **Pictures** are rendered with Blender, in appearances drawn at random. The {{ total.episodes }} episodes show
  {{ looks.appearances }} of them, with {{ looks.tables }} tables and {{ looks.rooms }} rooms and their light;
  the head camera's elevation {{ looks.elevation }}.
  {{ looks.scanned }} of {{ total.episodes }} episodes show the garment's scanned texture,
  the others {{ looks.fabrics }} made-up fabrics; names and numbers are in `look` of `provenance.parquet`.
* **Garments and robot** move in a simulation. States are the simulated joint angles, actions the commands that lead
  to the next frame's.
* **Garment shapes** come from the scans that the pipeline was given. Those that the project ships are virtual: made by a model of
  a depth camera, not by a scanner.
* **Demonstrations** that the trajectories were grown from are those of a scripted expert, but for garments
  for which a person's commands lay in `data/demonstrations/`.

## Columns

| column | shape | meaning |
| --- | --- | --- |
{% for name, feature in features -%}
| `{{ name }}` | {{ feature.shape|list }} | {{ meaning(name) }} |
{% endfor %}
`{{ keypoints }}` is privileged: only a simulator knows where the garment is. Its name does not begin with `observation`, so that no
policy of LeRobot takes it for an input. `keypoints.json` names, for each garment, the mesh vertices in it: farthest-point sampling on the
rest shape, starting with the vertex farthest from the mean.

![Joint angles of state and action in the first episode of every garment](motion.png)

## Provenance

`provenance.parquet` has a row per episode: garment, trajectory, appearance, source demonstrations, seed, physics (JSON, of the
simulated cloth: values, effects and digest of the fitted model, and the verdict on whether it explains the recordings), `scores`
(JSON: the judge's figures, what state rules and video discriminator decided, and whether the latter abstained), `cameras` (JSON, of
each: intrinsics in pixels and pose as rendered), and everything that the trajectory's own file says (`about`, JSON). Moments of every
episode (`reference_...`) and the digest of the simulation's file let `sim1 dataset check` tell whether data and pictures are its own.
Episodes with the same garment and trajectory show
the same motion in another appearance: keep them on the same side of a split.

## Reading it

```python
from lerobot.datasets.lerobot_dataset import LeRobotDataset

dataset = LeRobotDataset("{{ name }}", root="lerobot", video_backend="pyav")
print(dataset[0]["observation.state"], dataset[0]["task"])
```

To look at an episode (LeRobot's viewer, `pip install "lerobot[dataset-viz]"`, which brings rerun):
`lerobot-dataset-viz --repo-id {{ name }} --root lerobot --episode-index 0`
"""

MEANINGS = {
    "observation.state": "joint angles (rad) and openness (0 closed, 1 open), left arm then right arm",
    "action": "what to command from this frame to the next, to get to the state there: of the 30 commands a second, the last one before it",
    KEYPOINTS: "positions of garment keypoints in the world frame (m), from the simulation: privileged, no input of a policy for a robot",
}


def licenses_of(folder: Path) -> tuple[str, ...] | None:
    """Licenses that the card in a folder names; None where no card of this form is there.

    Raises:
        BadInput: what stands at the head of the card cannot be read.
    """
    path = folder / FILE
    if not path.is_file() or not (text := path.read_text(errors="replace")).startswith("---\n"):
        return None
    try:
        named = yaml.safe_load(text.split("---\n", 2)[1])["license"]
    except (yaml.YAMLError, KeyError, TypeError, IndexError) as error:
        raise BadInput(
            f"{path}: no license at its head ({error!r}); write `license: NAME` between its first two lines of `---`"
        ) from error
    return tuple(map(str, named)) if isinstance(named, list) else (str(named),)


def write_card(out: Path, provenance: pd.DataFrame, *, name: str, licenses: Sequence[str]) -> Facts:
    """Write `README.md` and its pictures; returns the figures in it."""
    info = json.loads((out / "lerobot" / "meta" / "info.json").read_text())
    table = [
        {
            "garment": garment,
            "task": rows["task"].iloc[0],
            "trajectories": int(rows["trajectory"].nunique()),
            "episodes": len(rows),
            "frames": int(rows["frame_count"].sum()),
            "mean_s": float(rows["frame_count"].mean() / info["fps"]),
        }
        for garment, rows in provenance.groupby("garment", sort=True)
    ]
    frames = int(provenance["frame_count"].sum())
    files = [path for path in (out / "lerobot").rglob("*") if path.is_file()]
    total = {
        "episodes": len(provenance),
        "frames": frames,
        "minutes": frames / info["fps"] / 60.0,
        "size_mb": sum(path.stat().st_size for path in files) / 1e6,
    }
    looks = _looks(provenance["look"])
    write_frames_picture(out, provenance)
    write_motion_picture(out, provenance)
    features = [
        (key, feature)
        for key, feature in info["features"].items()
        if key.startswith(("observation", "action")) or key == KEYPOINTS
    ]
    text = Environment(autoescape=False, keep_trailing_newline=True).from_string(CARD)  # Markdown, not HTML
    (out / FILE).write_text(
        text.render(
            licenses=licenses,
            total=total,
            info=info,
            table=table,
            looks=looks,
            features=features,
            meaning=_meaning,
            name=name,
            keypoints=KEYPOINTS,
        )
    )
    return {"episodes": len(provenance), "frames": frames, "size_mb": round(total["size_mb"], 3), "garments": table}


def _looks(column: pd.Series) -> dict[str, int | str]:
    """How many appearances and names of each sort there are, how often the measured texture, and the camera."""
    looks = [json.loads(look) for look in column]
    names = {sort: [look[sort]["name"] for look in looks] for sort in ("fabric", "table", "room")}
    turns_deg = np.degrees([look.get("elevation_offset_rad", 0.0) for look in looks])
    low, high = turns_deg.min(), turns_deg.max()
    varies = f"varies by {low:+.1f}° to {high:+.1f}° from where the scene has it"
    return {
        "appearances": len({json.dumps(look, sort_keys=True) for look in looks}),
        "elevation": varies if high > low else f"is the same in all of them, {low:+.1f}° from where the scene has it",
        "scanned": names["fabric"].count(SCANNED),
        "fabrics": len({*names["fabric"]} - {SCANNED}),
        "tables": len({*names["table"]}),
        "rooms": len({*names["room"]}),
    }


def _meaning(column: str) -> str:
    if column.startswith("observation.images."):
        return f"view of the {column.removeprefix('observation.images.')} camera, RGB, rendered"
    return MEANINGS[column]
