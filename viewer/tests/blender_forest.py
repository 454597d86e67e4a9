# blender --background --python blender_forest.py -- FILE.glb RECIPE.py [CLIP]
# Imports the file, runs the recipe of the guide, and fails unless every copy plays the same loop from another instant.
import sys

import bpy
import numpy

numpy.bool = bool  # Debian 12's Blender 3.4 uses this name, its numpy no longer has it

glb, recipe, *clip = sys.argv[sys.argv.index("--") + 1 :]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=glb)
# The importer draws bones as a mesh of its own.
drawn = {thing for thing in bpy.data.objects if thing.type == "MESH" and thing.name.startswith("Icosphere")}
(tree,) = [thing for thing in bpy.data.objects if thing.type == "MESH" and thing not in drawn]


def shape(plant, frame):
    bpy.context.scene.frame_set(frame)
    mesh = plant.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    return numpy.array([vertex.co for vertex in mesh.vertices])


# What moves it: the armature, or the shape keys.
def animation_of(plant):
    armature = plant.find_armature()
    return (armature or plant.data.shape_keys).animation_data


for name in clip:
    animation_of(tree).action = animation_of(tree).nla_tracks[name].strips[0].action
action = animation_of(tree).action
length = int(action.frame_range[1] - action.frame_range[0])
exec(compile(open(recipe).read(), recipe, "exec"))
copies = [thing for thing in bpy.data.objects if thing.type == "MESH" and thing != tree and thing not in drawn]
assert len(copies) > 3, len(copies)
shifts = set()
for copy in copies:
    start = next(track for track in animation_of(copy).nla_tracks if not track.mute).strips[0].frame_start
    shifts.add(start)
    for frame in (0, 10, length + 10):
        wanted = shape(tree, int(frame - start) % length)
        # An armature that stands elsewhere rounds otherwise.
        assert numpy.allclose(shape(copy, frame), wanted, rtol=0, atol=1e-6), (copy.name, frame)
    assert not numpy.allclose(shape(copy, 0), shape(tree, 0), rtol=0, atol=1e-3), copy.name
    if tree.find_armature():
        assert copy.data == tree.data and copy.find_armature() != tree.find_armature()
        assert copy.find_armature().data == tree.find_armature().data
assert len(shifts) == len(copies), shifts
