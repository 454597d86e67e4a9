tool
extends EditorPlugin

func _enter_tree():
	get_editor_interface().get_resource_filesystem().connect("resources_reimported", self, "_say")

func _say(paths):
	print("imported ", paths)
