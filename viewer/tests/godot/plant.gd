# What Godot has made of a plant, for whoever asks.
extends Reference

static func skeleton_of(plant):
	return plant.get_node("Skeleton")

static func skin_of(plant):
	return skeleton_of(plant).get_child(0)

# World positions [[x, y, z], …] of all vertices, z up, as the graphics card works them out.
static func vertices(plant):
	var skeleton = skeleton_of(plant)
	var instance = skin_of(plant)
	var carriers = []
	for bind in range(instance.skin.get_bind_count()):
		var bone = skeleton.find_bone(instance.skin.get_bind_name(bind))
		carriers.append(skeleton.get_bone_global_pose(bone) * instance.skin.get_bind_pose(bind))
	var result = []
	for surface in range(instance.mesh.get_surface_count()):
		var arrays = instance.mesh.surface_get_arrays(surface)
		var bones = arrays[Mesh.ARRAY_BONES]
		var weights = arrays[Mesh.ARRAY_WEIGHTS]
		var points = arrays[Mesh.ARRAY_VERTEX]
		for i in range(points.size()):
			var at = Vector3()
			for k in range(4 * i, 4 * i + 4):
				if weights[k] > 0:
					at += weights[k] * carriers[bones[k]].xform(points[i])
			at = skeleton.global_transform.xform(at)
			result.append([at.x, -at.z, at.y])
	return result

# Turns of the bones, as quaternions x y z w.
static func turns(plant):
	var skeleton = skeleton_of(plant)
	var result = []
	for bone in range(skeleton.get_bone_count()):
		var turn = skeleton.get_bone_pose(bone).basis.get_rotation_quat()
		result.append([turn.x, turn.y, turn.z, turn.w])
	return result
