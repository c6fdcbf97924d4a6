"""The card of a generated dataset in shards: `README.md`, whose head Hugging Face's `datasets` and hub read.

Reference: https://huggingface.co/docs/hub/datasets-cards
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Mapping
from typing import Any, Final

from cadet.formats.exporter import Split
from cadet.formats.kitti.croissant import ABOUT, LICENSE, REPOSITORY, summary_of, title_of

CARD: Final = "README.md"
"""Its name in a dataset."""
SPLITS: Final[Mapping[Split, str]] = {"train": "train", "val": "validation", "test": "test"}
"""What `datasets` calls our splits."""
_SIZES: Final = ("n<1K", "1K<n<10K", "10K<n<100K", "100K<n<1M", "1M<n<10M")
_TAGS: Final = ("synthetic", "lidar", "kitti", "3d-object-detection", "autonomous-driving")
_FIDELITY: Final = f"{REPOSITORY}/blob/main/docs/fidelity.md#known-differences-from-kitti"


def dataset_card(head: Mapping[str, Any], shards: Mapping[Split, str], columns: str, recipe: str | None) -> bytes:
    """Return a generated dataset's card, without a date.

    Args:
        head: what `manifest.json` says besides the hashes of files.
        shards: a pattern of the files of each split that has any.
        columns: what a sample holds, in Markdown.
        recipe: the text of its recipe; None where files of the user's are needed to make it.
    """
    num_frames, labels = head["counts"]["frames"], head["counts"]["labels"]
    objects = ", ".join(f"{count} {name}" for name, count in labels.items() if name != "DontCare")
    size = _SIZES[bisect_right([10**3, 10**4, 10**5, 10**6], num_frames)]
    files = "\n".join(f"  - {{split: {SPLITS[split]}, path: {json.dumps(path)}}}" for split, path in shards.items())
    made = (
        f"`cadet-gen again --recipe recipe.toml` makes the same bytes again, of these settings:\n\n```toml\n{recipe}```"
        if recipe is not None
        else "Maps or meshes of the user's own were used. manifest.json has all settings."
    )
    return f"""---
pretty_name: {json.dumps(title_of(head))}
license: other
license_name: cadet-generated-data
license_link: {LICENSE}
task_categories:
- object-detection
size_categories:
- {size}
tags: [{", ".join(_TAGS)}]
configs:
- config_name: default
  data_files:
{files}
---

# {title_of(head)}

{summary_of(head)}

{ABOUT["rai:dataCollection"]} {ABOUT["rai:dataAnnotationProtocol"]} {ABOUT["rai:dataUseCases"]}

## What a frame holds

{columns}

All frames together: {objects}.

## Limits

{ABOUT["rai:dataLimitations"]} {ABOUT["rai:dataBiases"]} Differences from KITTI that were measured: {_FIDELITY}.

## License

The program claims no rights in what it generates: {LICENSE}.
Personal information: {ABOUT["rai:personalSensitiveInformation"]}

## Recipe

{made}
""".encode()
