# blender --background --python blender_forest.py -- FILE.glb RECIPE.py
# Imports the file, runs the recipe of the guide, and fails unless every copy plays the same loop from another instant.
import sys

import bpy
import numpy

numpy.bool = bool  # Debian 12's Blender 3.4 uses this name, its numpy no longer has it

glb, recipe = sys.argv[sys.argv.index("--") + 1 :]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=glb)
(tree,) = [thing for thing in bpy.data.objects if thing.type == "MESH"]


def shape(plant, frame):
    bpy.context.scene.frame_set(frame)
    mesh = plant.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    return numpy.array([vertex.co for vertex in mesh.vertices])


action = tree.data.shape_keys.animation_data.action
length = int(action.frame_range[1] - action.frame_range[0])
exec(compile(open(recipe).read(), recipe, "exec"))
copies = [thing for thing in bpy.data.objects if thing.type == "MESH" and thing != tree]
assert len(copies) > 3, len(copies)
shifts = set()
for copy in copies:
    start = copy.data.shape_keys.animation_data.nla_tracks[0].strips[0].frame_start
    shifts.add(start)
    for frame in (0, 10, length + 10):
        wanted = shape(tree, int(frame - start) % length)
        assert numpy.array_equal(shape(copy, frame), wanted), (copy.name, frame)
    assert not numpy.array_equal(shape(copy, 0), shape(tree, 0)), copy.name
assert len(shifts) == len(copies), shifts
