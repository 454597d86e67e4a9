# godot3-server --path PROJECT -s forest_look.gd: runs the recipes of the guide on plant.glb, clips "calm" and "gale", and
# writes forest.json: every plant where it begins, some seconds on, before and after it fades; and one between both winds
# in a tree.
extends SceneTree

const Plant = preload("plant.gd")

func write(path, what):
	var file = File.new()
	file.open(path, File.WRITE)
	file.store_string(to_json(what))
	file.close()

func forest():
	var forest = load("res://forest.gd").new()
	forest.clip = "calm"
	get_root().add_child(forest)
	var plants = []
	for player in forest.players:
		var at = player.get_parent().translation
		var now = player.current_animation_position
		plants.append({"at": [at.x, -at.z, at.y], "now": now, "first": Plant.vertices(player.get_parent())})
	for i in range(plants.size()):
		forest.players[i].advance(13.7)
		plants[i]["later"] = Plant.vertices(forest.players[i].get_parent())
	forest.fade_to("gale", 4.0)
	for i in range(plants.size()):
		var plant = forest.players[i].get_parent()
		forest.players[i].advance(0)
		plants[i]["before"] = Plant.vertices(plant)
		forest.players[i].advance(5)
		forest.players[i].advance(0)  # it drops what has faded a step later
		plants[i]["after"] = Plant.vertices(plant)
	return plants

func winds():
	var plant = load("res://plant.glb").instance()
	for name in ["calm", "gale"]:
		plant.get_node("AnimationPlayer").get_animation(name).loop = true
	var tree = load("res://winds.gd").new()
	plant.add_child(tree)
	get_root().add_child(plant)
	tree.process_mode = AnimationTree.ANIMATION_PROCESS_MANUAL
	tree.set_wind(0)
	tree.begin_at(5)
	for step in range(2):             # it takes in where to begin in one, and is there in the next
		tree.advance(0)
	var found = {"calm": Plant.vertices(plant)}
	tree.advance(2)
	tree.set_wind(1)
	tree.advance(0)
	found["gale"] = Plant.vertices(plant)
	tree.set_wind(0.5)
	tree.advance(0)
	found["between"] = Plant.turns(plant)
	return found

func turns_of_clips():
	var plant = load("res://plant.glb").instance()
	get_root().add_child(plant)
	var player = plant.get_node("AnimationPlayer")
	var found = {}
	for name in ["calm", "gale"]:
		player.play(name)
		player.seek(7, true)
		found[name] = Plant.turns(plant)
	return found

func _idle(_seconds):
	write("res://forest.json", {"plants": forest(), "winds": winds(), "turns": turns_of_clips()})
	quit()
