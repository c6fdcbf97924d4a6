"""From AVOD's outputs to boxes."""

from __future__ import annotations

from torch import Tensor

from avod.config import DetectionConfig
from avod.geometry.encoding import boxes_4c_from_anchors, boxes_from_4c
from avod.geometry.orientation import fix_up
from avod.model.avod.outputs import FrameOutputs
from avod.model.boxes import Boxes, kept_boxes


def decode(outputs: FrameOutputs, plane: Tensor, config: DetectionConfig) -> Boxes:
    """Decode proposals, drop the lesser ones, choose headings.

    Boxes of all classes together are ranked by the greatest logit of a class, which need not have the highest score:
    that depends on the others' too.

    Args:
        outputs: of the network.
        plane: (4,) ground plane of the sample.
        config: overlap and number.
    """
    boxes_4c = boxes_4c_from_anchors(outputs.proposals, plane) + outputs.box_offsets
    boxes_cam = boxes_from_4c(boxes_4c, plane)
    scores, classes = outputs.class_logits.softmax(dim=1)[:, 1:].max(dim=1)
    kept = kept_boxes(boxes_cam, scores, classes, config, ranks=outputs.class_logits[:, 1:].amax(dim=1))
    fixed = fix_up(boxes_cam[kept], outputs.vectors[kept], is_reference=config.fix_up == "reference")
    return Boxes(fixed, scores[kept], classes[kept] + 1)
