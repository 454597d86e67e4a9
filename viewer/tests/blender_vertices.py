# blender --background --python blender_vertices.py -- FILE.glb OUT.json FPS FRAME…
# Imports the file as an artist would and writes where its vertices are: with the weights of the mesh, which are those at
# rest, or on bones at rest, and evaluated at each frame; on bones for every clip by its name.
import json
import sys

import bpy
import numpy

numpy.bool = bool  # Debian 12's Blender 3.4 uses this name, its numpy no longer has it

glb, out, fps, *frames = sys.argv[sys.argv.index("--") + 1 :]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = int(fps)
bpy.ops.import_scene.gltf(filepath=glb)
# The importer draws bones as a mesh of its own.
(plant,) = [thing for thing in bpy.data.objects if thing.type == "MESH" and not thing.name.startswith("Icosphere")]
keys = plant.data.shape_keys.key_blocks if plant.data.shape_keys else []


def world(points):
    return [list(plant.matrix_world @ point.co) for point in points]


def poses():
    found = {}
    for frame in frames:
        bpy.context.scene.frame_set(int(frame))
        evaluated = plant.evaluated_get(bpy.context.evaluated_depsgraph_get())
        found[frame] = world(evaluated.to_mesh().vertices)
    return found


armatures = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
by_clip = {}
for armature in armatures:
    for track in armature.animation_data.nla_tracks:
        armature.animation_data.action = track.strips[0].action
        by_clip[track.name] = poses()

with open(glb, "rb") as file:
    header = file.read(20)
    document = json.loads(file.read(int.from_bytes(header[12:16], "little")))
weights = document["meshes"][0].get("weights", [])
rest = numpy.array(world(keys[0].data if keys else plant.data.vertices))
rest = rest + sum(w * (numpy.array(world(key.data)) - rest) for w, key in zip(weights, keys[1:]))
with open(out, "w") as file:
    json.dump({"keys": [key.name for key in keys], "rest": rest.tolist(), "poses": {} if armatures else poses(),
               "bones": [len(armature.data.bones) for armature in armatures], "clips": by_clip}, file)
