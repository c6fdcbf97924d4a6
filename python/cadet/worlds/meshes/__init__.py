"""Meshes of other people's programs, Wavefront OBJ and glTF 2.0: their triangles, and what colors each of them."""

from cadet.worlds.meshes.beside import Beside
from cadet.worlds.meshes.gltf import gltf_from_bytes
from cadet.worlds.meshes.obj import obj_from_bytes
from cadet.worlds.meshes.triangles import MeshMaterial, MeshTriangles

__all__ = ["Beside", "MeshMaterial", "MeshTriangles", "gltf_from_bytes", "obj_from_bytes"]
