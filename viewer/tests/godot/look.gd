# godot3-server --path PROJECT -s look.gd: writes look.json about plant.glb at the times that times.json has for each clip.
extends SceneTree

const Plant = preload("plant.gd")

func read(path):
	var file = File.new()
	file.open(path, File.READ)
	return parse_json(file.get_as_text())

func write(path, what):
	var file = File.new()
	file.open(path, File.WRITE)
	file.store_string(to_json(what))
	file.close()

func _idle(_seconds):
	var plant = load("res://plant.glb").instance()
	get_root().add_child(plant)
	var instance = Plant.skin_of(plant)
	var player = plant.get_node("AnimationPlayer")
	var found = {
		"joints": Plant.skeleton_of(plant).get_bone_count(),
		"binds": instance.skin.get_bind_count(),
		"materials": [],
		"rest": Plant.vertices(plant),
		"high": instance.get_aabb().size.y,
		"clips": {},
	}
	for surface in range(instance.mesh.get_surface_count()):
		found["materials"].append(instance.mesh.surface_get_material(surface).resource_name)
	var times = read("res://times.json")
	for name in player.get_animation_list():
		var clip = player.get_animation(name)
		var poses = []
		player.play(name)
		for time in times.get(name, []):
			player.seek(time, true)
			poses.append(Plant.vertices(plant))
		found["clips"][name] = {"length": clip.length, "loop": clip.loop, "tracks": clip.get_track_count(), "poses": poses}
	write("res://look.json", found)
	quit()
