# blender --background --python beside_cycles.py -- TREMULA FOLDER [PICTURE.png DOCUMENT.md]
# Draws scene.toml with tremula and with Blender's Cycles, under a uniform sky and under sun and sky, writes the mean
# grey levels of both by region into FOLDER/table, and ends with 1 where they are more than 3 per cent apart. With two
# more words it makes the picture and puts the table into the document, too. See ../beside_cycles.sh.
import math
import os
import struct
import subprocess
import sys
import tomllib
import zlib

import bpy
import numpy
from mathutils import Matrix, Vector
from mathutils.kdtree import KDTree

numpy.bool = bool  # Blender 3.4's importer uses this name, newer numpys no longer have it

tremula, work, *kept = sys.argv[sys.argv.index("--") + 1 :]
here = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(here, "scene.toml")) as file:
    text = file.read()
scene = tomllib.loads(text)
width, height = map(int, scene["picture"]["size"].split("x"))
frame, allowed = 37, 3.0  # of the loop; [%]
azimuth, elevation = -165, 40  # of the sun [degrees]
sky_line, sun_and_sky = "uniform = 1", f"sun_elevation = {elevation}\nsun_azimuth = {azimuth}\nturbidity = 3"
level = math.cos(math.radians(elevation))
to_sun = Vector((level * math.cos(math.radians(azimuth)), level * math.sin(math.radians(azimuth)),
                 math.sin(math.radians(elevation))))
sun_radius = 0.004675  # [rad] sun_angular_radius of src/tremula/render/atmosphere.hpp


# ---- tremula

def run(*words):
    done = subprocess.run([tremula, *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)


def pixels(path):  # (rows from the top, columns, 3), linear
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    values = numpy.empty(4 * image.size[0] * image.size[1], numpy.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(image.size[1], image.size[0], 4)[::-1, :, :3].astype(float)
    bpy.data.images.remove(image)
    return values


def scene_file(name, replaced):
    changed = text
    for old, new in replaced:
        assert old in changed, old
        changed = changed.replace(old, new)
    for source in ("table.toml",):
        changed = changed.replace(f'"{source}"', f'"{os.path.join(here, source)}"')
    path = os.path.join(work, name + ".toml")
    with open(path, "w") as file:
        file.write(changed)
    return path


def table_of(header):
    begin = text.index(f"[{header}]")
    return text[begin : text.index("\n[", begin)]


def drawn_by_tremula(name, replaced):
    out = os.path.join(work, name + ".exr")
    run("render", scene_file(name, replaced), "--frames", frame, "-o", out)
    return pixels(out)


# The light alone, as tremula shows it: the same exposure as the picture's.
def far_light(name, direction, degrees, size, stops):
    objects = text[text.index("[[objects]]") :]
    out = os.path.join(work, name + ".exr")
    path = scene_file(name, [
        (table_of("ground"), '[ground]\nkind = "none"\n'), (sky_line, sun_and_sky),
        (table_of("camera"), f"[camera]\neye = [0, 0, 0]\nlook_at = {list(direction)}\nfield_of_view = {degrees}\n"),
        (objects, '[[objects]]\nsource = "table.toml"\n[[objects.instances]]\nposition = [0, 0, -1e6]\n')])
    run("render", path, "--frames", frame, "--size", f"{size}x{size}", "--samples", 4, "--exposure",
        scene["picture"]["exposure"] + stops, "-o", out)
    return pixels(out) * 2.0**-stops


def axes_of(forward):
    forward = numpy.array(forward, float) / numpy.linalg.norm(forward)
    right = numpy.cross(forward, [0, 0, 1])
    right /= numpy.linalg.norm(right)
    return forward, right, numpy.cross(right, forward)


# The sun's irradiance on a plane that faces it: the radiance of its disc times the solid angle.
def sun_irradiance():
    size = 64
    disc = far_light("sun", to_sun, 0.5, size, -14)[size // 2, size // 2]
    behind = far_light("sky", to_sun, 4, size, 0)[0, 0]
    return (disc - behind) * 2 * math.pi * (1 - float(numpy.float32(math.cos(sun_radius))))  # which has it in floats


# All around, as Blender wants it: the upper half from four pictures, the sun's disc taken out.
def panorama(rows):
    v, u = numpy.mgrid[0:rows, 0 : 2 * rows]
    polar = math.pi * (0.5 - (v + 0.5) / rows)
    around = 2 * math.pi * (0.5 - (u + 0.5) / (2 * rows))  # the middle looks along +x, +y is to the left
    directions = numpy.stack((numpy.cos(polar) * numpy.cos(around), numpy.cos(polar) * numpy.sin(around),
                              numpy.sin(polar)), -1)
    result = numpy.zeros((rows, 2 * rows, 3))
    degrees, size = 112, 1024
    half = math.tan(math.radians(degrees) / 2)
    for k in range(4):
        turn = k * math.pi / 2
        forward, right, up = axes_of((math.cos(turn), math.sin(turn), 1))
        face = far_light(f"sky_{k}", forward, degrees, size, 0)
        mine = (numpy.abs((around - turn + math.pi) % (2 * math.pi) - math.pi) <= math.pi / 4) & (polar > 0)
        towards = directions[mine]
        depth = towards @ forward
        x = (towards @ right / depth / half + 1) / 2 * size - 0.5
        y = (1 - towards @ up / depth / half) / 2 * size - 0.5
        x0, y0 = numpy.floor(x).astype(int).clip(0, size - 2), numpy.floor(y).astype(int).clip(0, size - 2)
        a, b = (x - x0)[:, None], (y - y0)[:, None]
        result[mine] = ((1 - a) * (1 - b) * face[y0, x0] + a * (1 - b) * face[y0, x0 + 1] +
                        (1 - a) * b * face[y0 + 1, x0] + a * b * face[y0 + 1, x0 + 1])
    result[rows // 2 :] = result[rows // 2 - 1]  # what is below the horizon is blended into it
    angle = numpy.degrees(numpy.arccos((directions @ numpy.array(to_sun)).clip(-1, 1)))
    ring = (angle > 0.8) & (angle < 1.3)
    result[angle <= 0.8] = result[ring].mean(0)
    return result


# ---- Materials, as src/tremula/raytrace/{path,scattering}.cpp have them

def linear(srgb):
    return [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in srgb]


# What light reflects at a surface of refractive index 1.5 (Fresnel).
def fresnel(cosine, index=1.5):
    g = numpy.sqrt(index**2 - 1 + cosine**2)
    a = (g - cosine) / (g + cosine)
    b = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)
    return a * a * (1 + b * b) / 2


# The share of light from a direction that Cycles' coat sends back, by samples of the facets that are seen (Heitz 2018).
# Facets hide and shadow each other independently there.
def coat_share(cosine, alpha, grid=64):
    a, b = (numpy.mgrid[0:grid, 0:grid].reshape(2, -1) + 0.5) / grid
    eye = numpy.array([math.sqrt(1 - cosine**2), 0, cosine])
    stretched = numpy.array([alpha * eye[0], 0, eye[2]])
    stretched /= numpy.linalg.norm(stretched)
    x = numpy.array([0, 1.0, 0])
    y = numpy.cross(stretched, x)
    radius, angle = numpy.sqrt(a), 2 * math.pi * b
    p, q = radius * numpy.cos(angle), radius * numpy.sin(angle)
    s = (1 + stretched[2]) / 2
    q = (1 - s) * numpy.sqrt(1 - p**2) + s * q
    facet = (p[:, None] * x + q[:, None] * y +
             numpy.sqrt(numpy.maximum(0, 1 - p**2 - q**2))[:, None] * stretched)
    normal = facet * [alpha, alpha, 1]
    normal /= numpy.linalg.norm(normal, axis=1)[:, None]
    along = normal @ eye
    up = 2 * along * normal[:, 2] - eye[2]  # of the light
    lit = up > 0
    shadowed = (numpy.sqrt(1 + alpha**2 * (1 / up[lit] ** 2 - 1)) - 1) / 2
    return float((fresnel(along[lit]) / (1 + shadowed)).sum() / grid**2)


class Nodes:
    def __init__(self, name):
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()

    def new(self, kind, *inputs, **settings):
        node = self.tree.nodes.new(kind)
        for key, value in settings.items():
            setattr(node, key, value)
        for socket, value in zip(node.inputs, inputs):
            if value is None:
                continue
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif hasattr(socket.default_value, "__len__"):
                socket.default_value = (*value, 1) if len(socket.default_value) == 4 else value
            else:
                socket.default_value = value
        return node

    def math(self, operation, *inputs):
        return self.new("ShaderNodeMath", *inputs, operation=operation).outputs[0]

    def scaled(self, vector, factor):
        node = self.new("ShaderNodeVectorMath", vector, operation="SCALE")
        if isinstance(factor, bpy.types.NodeSocket):
            self.tree.links.new(factor, node.inputs["Scale"])
        else:
            node.inputs["Scale"].default_value = factor
        return node.outputs[0]

    def vector(self, operation, a, b):
        node = self.new("ShaderNodeVectorMath", a, b, operation=operation)
        return node.outputs["Value" if operation == "DOT_PRODUCT" else 0]

    def diffuse(self, color):
        return self.new("ShaderNodeBsdfDiffuse", color).outputs[0]

    def through(self, color):
        return self.new("ShaderNodeBsdfTranslucent", color).outputs[0]

    def both(self, a, b):
        return self.new("ShaderNodeAddShader", a, b).outputs[0]

    # A coat sends back its share of what comes from the eye's way and leaves the rest to what is below.
    def coated(self, below, roughness):
        alpha = roughness**2
        geometry = self.new("ShaderNodeNewGeometry")
        cosine = self.math("ABSOLUTE", self.vector("DOT_PRODUCT", geometry.outputs["Normal"],
                                                   geometry.outputs["Incoming"]))
        ramp = self.new("ShaderNodeValToRGB", cosine)
        elements, steps = ramp.color_ramp.elements, 24
        for i in range(steps + 1):
            place = (i / steps) ** 2  # closer where the share is steep
            element = elements[i] if i < 1 else (elements[-1] if i == steps else elements.new(place))
            element.position = place
            element.color = (*[coat_share(max(place, 0.002), alpha)] * 3, 1)
        coat = self.new("ShaderNodeBsdfPrincipled", (0, 0, 0), distribution="GGX")
        coat.inputs["Roughness"].default_value, coat.inputs["Specular"].default_value = roughness, 0.5
        black = self.diffuse((0, 0, 0))
        left = self.new("ShaderNodeMixShader", ramp.outputs[0], below, black).outputs[0]
        return self.both(left, coat.outputs[0])

    def done(self, surface):
        self.new("ShaderNodeOutputMaterial", surface)
        return self.material


def dull(name, albedo):
    nodes = Nodes(name)
    return nodes.done(nodes.diffuse(albedo))


def cloth(name, color):
    nodes = Nodes(name)
    return nodes.done(nodes.both(nodes.diffuse([0.7 * c for c in color]), nodes.through([0.3 * c for c in color])))


def panel(name, color):
    nodes = Nodes(name)
    return nodes.done(nodes.coated(nodes.diffuse(color), 0.5))


# As patterns.cpp paints it; how each leaf differs from the rest is an attribute of its corners (hues_of_leaves).
def leaf(name, color):
    nodes = Nodes(name)
    mean = sum(color) / 3
    hue = nodes.new("ShaderNodeAttribute", attribute_name="hue").outputs["Color"]
    pale = nodes.vector("MULTIPLY", hue, [c + 0.08 * (mean - c) for c in color])
    place = nodes.new("ShaderNodeSeparateXYZ", nodes.new("ShaderNodeTexCoord").outputs["UV"]).outputs[0]
    off = nodes.math("ABSOLUTE", nodes.math("SUBTRACT", place, 0.5))
    rib = nodes.math("MAXIMUM", 0.0, nodes.math("SUBTRACT", 1.0, nodes.math("MULTIPLY", off, 14.0)))
    above = nodes.scaled(pale, nodes.math("ADD", 1.0, nodes.math("MULTIPLY", rib, 0.35)))
    grey = nodes.vector("DOT_PRODUCT", above, (1 / 3, 1 / 3, 1 / 3))
    below = nodes.vector("ADD", nodes.scaled(above, 0.8), nodes.scaled((1, 1, 1), nodes.math("MULTIPLY", grey, 0.25)))
    behind = nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"]
    reflected = nodes.vector("ADD", above, nodes.scaled(nodes.vector("SUBTRACT", below, above), behind))
    transmitted = nodes.vector("MULTIPLY", reflected, [1.3 * 0.75 * c for c in (1.25, 1.2, 0.35)])
    return nodes.done(nodes.coated(nodes.both(nodes.diffuse(reflected), nodes.through(transmitted)), 0.6))


def hash_to_unit(x):
    x = numpy.asarray(x, numpy.uint32)
    x = (x ^ (x >> 16)) * numpy.uint32(0x7FEB352D)
    x = (x ^ (x >> 15)) * numpy.uint32(0x846CA68B)
    return ((x ^ (x >> 16)) >> 8) * 2.0**-24


# The number of a leaf makes its hue; a .glb has its triangles in another order, a skeleton's file has it.
def hues_of_leaves(source, at_rest, to_world, still):
    path = os.path.join(work, "leaves.swc")
    run("grow", source, "-o", path)
    with open(path) as file:
        leaves = numpy.array([line.split()[4:15] for line in file if line.startswith("# leaf ")], float)
    base, axis, up = leaves[:, 0:3], leaves[:, 3:6], leaves[:, 6:9]
    length, wide = leaves[:, 9:10], leaves[:, 10:11]
    up = up - axis * (axis * up).sum(1, keepdims=True)
    up /= numpy.linalg.norm(up, axis=1, keepdims=True)
    across = numpy.cross(axis, up)
    shape = ((0, 0, 0), (0, 0.45, 0.06), (0, 1, 0), (-0.5, 0.24, 0.12), (-0.43, 0.58, 0.12), (0.5, 0.24, 0.12),
             (0.43, 0.58, 0.12))
    corners = numpy.stack([base + x * wide * across + y * length * axis + z * wide * up for x, y, z in shape], 1)
    faces = ((0, 1, 3), (3, 1, 4), (4, 1, 2), (0, 5, 1), (5, 6, 1), (6, 2, 1))
    tree = KDTree(len(leaves) * len(faces))
    for number, of_leaf in enumerate(corners):
        for face in faces:
            tree.insert(of_leaf[list(face)].mean(0), number)
    tree.balance()
    numbers = numpy.arange(len(leaves))
    bright, yellow = 0.78 + 0.44 * hash_to_unit(2 * numbers), hash_to_unit(2 * numbers + 1) - 0.5
    hues = numpy.stack((1 + 0.55 * yellow, 1 + 0.1 * yellow, 1 - 0.5 * yellow, 1 / bright), 1) * bright[:, None]
    layer = still.color_attributes.new("hue", "FLOAT_COLOR", "CORNER")
    for polygon in at_rest.polygons:
        if not at_rest.materials[polygon.material_index].name.startswith("leaf"):
            continue
        centre = sum((to_world @ at_rest.vertices[i].co for i in polygon.vertices), Vector()) / 3
        _, number, distance = tree.find(centre)
        assert distance < 1e-4, distance
        for corner in polygon.loop_indices:
            layer.data[corner].color = hues[number]


# ---- Blender's scene

def import_object(described):
    name = described["name"]
    path = os.path.join(work, name + ".glb")
    closely = ("--tolerance", 0.0002) if "leaf_color" in described else ()  # of a plant on bones
    run("animate", scene_file("objects", []), "--object", name, "--compress", "none", *closely, "-o", path)
    before = set(bpy.data.objects)
    bpy.ops.import_scene.gltf(filepath=path)
    new = set(bpy.data.objects) - before
    for armature in (thing for thing in new if thing.type == "ARMATURE"):
        armature.animation_data.action = armature.animation_data.nla_tracks[0].strips[0].action
    bpy.context.scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    (at,) = described["instances"]
    place = (Matrix.Translation(Vector((*at["position"], 0))) @ Matrix.Scale(at.get("scale", 1), 4))
    colors = {part: linear(described[key]) for part, key in (
        ("timber", "bark_color"), ("bark", "bark_color"), ("panel", "color"), ("cloth", "color"), ("leaf", "leaf_color")) if key in described}
    makers = {"timber": dull, "panel": panel, "cloth": cloth, "leaf": leaf, "bark": dull}
    shown_as = {"timber": "legs of the table", "panel": "board of the table", "leaf": "leaves",
                "cloth": "cloth, hanging"}
    kept = []
    for thing in [thing for thing in new if thing.type == "MESH" and not thing.name.startswith("Icosphere")]:
        mesh = bpy.data.meshes.new_from_object(thing.evaluated_get(graph), depsgraph=graph)
        still = bpy.data.objects.new(name, mesh)
        still.matrix_world = place @ thing.matrix_world
        if "leaf_color" in described:
            hues_of_leaves(described["source"], thing.data, thing.matrix_world, mesh)
        for i, material in enumerate(mesh.materials):
            part = material.name.split(".")[0]
            mesh.materials[i] = makers[part](shown_as.get(part, part), colors[part])
        kept.append(still)
    for thing in new:
        bpy.data.objects.remove(thing)
    for still in kept:
        bpy.context.collection.objects.link(still)


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    render = bpy.context.scene.render
    render.fps = scene["motion"]["fps"]
    for described in scene["objects"]:
        import_object(described)

    far = 20000.0  # [m]
    mesh = bpy.data.meshes.new("ground")
    mesh.from_pydata([(-far, -far, 0), (far, -far, 0), (far, far, 0), (-far, far, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(dull("ground", scene["ground"]["color"]))
    bpy.context.collection.objects.link(bpy.data.objects.new("ground", mesh))

    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit = "VERTICAL"
    lens.angle = math.radians(scene["camera"]["field_of_view"])
    lens.clip_end = 1e6
    camera = bpy.data.objects.new("camera", lens)
    eye = numpy.array(scene["camera"]["eye"])
    forward, right, up = axes_of(numpy.array(scene["camera"]["look_at"]) - eye)
    camera.matrix_world = Matrix(numpy.c_[numpy.c_[right, up, -forward, eye].T, [0, 0, 0, 1]].T.tolist())
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera

    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.use_persistent_data = True
    cycles = bpy.context.scene.cycles
    cycles.device, cycles.samples = "CPU", scene["picture"]["samples"]
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = 0
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", scene["picture"]["bounces"])
    cycles.pixel_filter_type, cycles.filter_width = "GAUSSIAN", 1.5
    bpy.context.scene.world = bpy.data.worlds.new("world")
    bpy.context.scene.world.use_nodes = True


def drawn_by_cycles(name):
    path = os.path.join(work, name + ".exr")
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return pixels(path)


def shine_evenly():
    background = bpy.context.scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = 1


def shine_as_sun_and_sky():
    irradiance = sun_irradiance()
    around = panorama(512)
    image = bpy.data.images.new("sky", around.shape[1], around.shape[0], float_buffer=True, is_data=True)
    image.pixels.foreach_set(numpy.dstack((around, numpy.ones(around.shape[:2])))[::-1].astype(numpy.float32).ravel())
    image.pack()
    tree = bpy.context.scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    lamp = bpy.data.lights.new("sun", "SUN")
    lamp.energy, lamp.color, lamp.angle = irradiance.max(), irradiance / irradiance.max(), 2 * sun_radius
    sun = bpy.data.objects.new("sun", lamp)
    sun.rotation_mode = "QUATERNION"
    sun.rotation_quaternion = to_sun.to_track_quat("Z", "Y")
    bpy.context.collection.objects.link(sun)


# ---- Regions: of every pixel that shows one thing alone, what that is

def regions():
    graph = bpy.context.evaluated_depsgraph_get()
    eye = Vector(scene["camera"]["eye"])
    forward, right, up = axes_of(numpy.array(scene["camera"]["look_at"]) - numpy.array(eye))
    half = math.tan(math.radians(scene["camera"]["field_of_view"]) / 2)
    table = Vector((*scene["objects"][0]["instances"][0]["position"], 0))

    def seen(x, y):
        towards = Vector(forward + (2 * x / width - 1) * half * width / height * right + (1 - 2 * y / height) * half * up)
        hit, place, normal, face, thing, _ = bpy.context.scene.ray_cast(graph, eye, towards)
        if not hit:
            return "sky", None, None
        mesh = thing.evaluated_get(graph).data
        return mesh.materials[mesh.polygons[face].material_index].name, place, normal

    def in_sun(place):
        return not bpy.context.scene.ray_cast(graph, place + Vector((0, 0, 1e-4)), to_sun)[0]

    even, sunny = numpy.full((height, width), "", object), numpy.full((height, width), "", object)
    for row in range(height):
        for column in range(width):
            spots = [seen(column + 0.5 + dx, row + 0.5 + dy) for dx, dy in ((0, 0), (-1, -1), (1, -1), (-1, 1), (1, 1))]
            name, place, normal = spots[0]
            if any(spot[0] != name for spot in spots):
                continue
            even[row, column] = sunny[row, column] = name
            if name == "ground":
                even[row, column] = sunny[row, column] = ""
                if (place - eye).length > 60:
                    continue
                from_table = place - table
                nearest = min((place - Vector((*each["instances"][0]["position"], 0))).length for each in scene["objects"])
                if nearest > 2.5:
                    even[row, column] = "ground, open"
                elif all(abs(spot[1].x - table.x) < 0.6 and abs(spot[1].y - table.y) < 0.4 for spot in spots):
                    even[row, column] = "ground under the table"
                lit = [in_sun(spot[1]) for spot in spots]
                if all(lit):
                    sunny[row, column] = "ground in the sun"
                elif not any(lit):
                    sunny[row, column] = "ground in shadow"
    return even, sunny


# ---- The table

lines = []


def compare(title, ours, theirs, names):
    lines.append(f"{title:24} {'pixels':>7} {'tremula':>9} {'Cycles':>9} {'apart':>10}")
    worst, few = 0, 100
    for name in sorted(set(names.ravel()) - {"", "bark"}):  # tremula's bark has a pattern
        mask = names == name
        if mask.sum() < few:
            continue
        a, b = ours[mask].mean(), theirs[mask].mean()
        apart = 100 * (a / b - 1)
        worst = max(worst, abs(apart))
        lines.append(f"{name:24} {mask.sum():7d} {a:9.4f} {b:9.4f} {apart:+8.2f} %")
    lines.append("")
    return worst


def shown(light, factor):
    light = (factor * light).clip(0, 1)
    return numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


# Rows of pictures side by side, three pixels made two.
def write_picture(path, rows):
    gap = 6
    across = lambda pair: numpy.concatenate((pair[0], numpy.ones((height, gap, 3)), pair[1]), 1)
    full = numpy.concatenate((across(rows[0]), numpy.ones((gap, 2 * width + gap, 3)), across(rows[1])), 0)
    for axis in (0, 1):
        full = numpy.moveaxis(full, axis, 0)
        a, b, c = (full[i : len(full) // 3 * 3 : 3] for i in range(3))
        full = numpy.stack(((2 * a + b) / 3, (b + 2 * c) / 3), 1).reshape(-1, *full.shape[1:])
        full = numpy.moveaxis(full, 0, axis)
    # Of every pixel how it differs from its left neighbour, which packs best; Blender packs the pixels themselves.
    bytes_of = numpy.round(255 * full).astype(numpy.uint8)
    differ = numpy.diff(bytes_of, axis=1, prepend=numpy.zeros_like(bytes_of[:, :1]))
    rows = b"".join(b"\x01" + row.tobytes() for row in differ)
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    header = struct.pack(">IIBBBBB", full.shape[1], full.shape[0], 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) +
                   chunk(b"IEND", b""))


# Into the block below the picture.
def write_table(document, table):
    with open(document) as file:
        before, picture, after = file.read().partition("beside-cycles.png)\n\n```text\n")
    assert picture, document
    with open(document, "w") as file:
        file.write(before + picture + table + after[after.index("```") :])


build()
even, sunny = regions()
shine_evenly()
theirs_even = drawn_by_cycles("cycles_even")
ours_even = drawn_by_tremula("tremula_even", [])
worst = compare("uniform sky", ours_even, theirs_even, even)
shine_as_sun_and_sky()
theirs_sunny = drawn_by_cycles("cycles_sunny")
ours_sunny = drawn_by_tremula("tremula_sunny", [(sky_line, sun_and_sky)])
worst = max(worst, compare("sun and sky", ours_sunny, theirs_sunny, sunny))
lines.append(f"farthest apart: {worst:.2f} %, allowed {allowed:g} %")
table = "\n".join(lines) + "\n"
with open(os.path.join(work, "table"), "w") as file:
    file.write(table)
if kept:
    write_picture(kept[0], [[shown(ours_even, 0.7), shown(theirs_even, 0.7)],
                            [shown(ours_sunny, 0.8), shown(theirs_sunny, 0.8)]])
    write_table(kept[1], table)
sys.exit(0 if worst <= allowed else 1)
