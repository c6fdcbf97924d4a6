"""Extensions of glTF: which are read, which change nothing that is, and what is done about the others."""

from __future__ import annotations

import re
from typing import Final

from cadet.errors import FileFormatError
from cadet.worlds.meshes.gltf_tables import Table

SPECULAR_GLOSSINESS: Final = "KHR_materials_pbrSpecularGlossiness"
TRANSMISSION: Final = "KHR_materials_transmission"
TEXTURE_TRANSFORM: Final = "KHR_texture_transform"
VISIBILITY: Final = "KHR_node_visibility"
PICTURES: Final = ("EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds")
"""Those that name another picture of a texture."""
DRACO: Final = "KHR_draco_mesh_compression"
COMPRESSED: Final = {
    DRACO: "decompress the file, with `gltf-transform copy IN OUT` or in Blender with compression off",
    "EXT_meshopt_compression": "decompress the file, with `gltf-transform copy IN OUT` or `gltfpack` without -c",
    "KHR_meshopt_compression": "decompress the file, with `gltf-transform copy IN OUT` or `gltfpack` without -c",
}
"""Those that keep shapes in other bytes, with what to do."""

_READ: Final = (SPECULAR_GLOSSINESS, TRANSMISSION, TEXTURE_TRANSFORM, VISIBILITY, "KHR_mesh_quantization", *PICTURES)
# Gloss, light, sound, meaning, animation: the shapes at rest and their base colors stay what they are.
_HARMLESS: Final = re.compile(
    r"KHR_(materials_(?!common)\w+|lights\w*|animation\w*|xmp\w*|audio\w*|node_\w+|interactivity\w*|physics\w*|collision\w*"
    r"|implicit_shapes|environment_map|accessor_float64|texture_transform)"
    r"|EXT_(lights_\w+|mesh_features|mesh_manifold|structural_metadata|feature_metadata|instance_features|mesh_polygon\w*"
    r"|property_\w+|primitive_\w+|animation\w*|materials_\w+)"
    r"|(ADOBE_materials|ASOBO|AGI|CESIUM|BLENDER|FB|GODOT|GRIFFEL|MAXAR|MOZ|MPEG|MSFT_(lod|packing|physics)|OMI|VRM|VRMC|SKETCHFAB"
    r"|UNITY|EXTRAS?)_?\w*"
)


def check_extensions(root: Table) -> list[str]:
    """Refuse what can't be read without an extension that is not.

    Returns:
        A line for each extension that may replace shapes or colors and is not read.

    Raises:
        FileFormatError: naming the extension and what to do.
    """
    required = root.texts("extensionsRequired")
    for name in required:
        if name in COMPRESSED:
            raise FileFormatError(f"it requires the extension {name}, which is not read: {COMPRESSED[name]}", root.file)
        if name not in _READ and not _HARMLESS.fullmatch(name):
            raise FileFormatError(
                f"it requires the extension {name.encode('ascii', 'backslashreplace').decode()}, which is not read: "
                "export it without, or as plain glTF 2.0 by `gltf-transform copy` or Blender",
                root.file,
            )
    used = dict.fromkeys(root.texts("extensionsUsed"))
    unknown = [n for n in used if n not in _READ and n not in COMPRESSED and not _HARMLESS.fullmatch(n)]
    return [f"{root.file}: the extension {n!a} is not read: shapes or colors that it replaces are not" for n in unknown]
