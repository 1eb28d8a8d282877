"""blender -b -P cycles_volume.py -- SCENE.json SPP SEED OUT.exr

Renders one of Spinel's scenes of one .vdb volume, a directional light and a constant environment with Cycles on one
thread of the processor, and prints the processor seconds of the rendering. See noise.py.
"""
import json
import math
import pathlib
import resource
import sys

import bpy
from mathutils import Matrix, Vector

path, spp, seed, output = sys.argv[sys.argv.index("--") + 1:]
lines = pathlib.Path(path).read_text().splitlines()
spinel = json.loads("\n".join(line for line in lines if not line.lstrip().startswith("//")))
(volume,) = spinel["geometries"].values()
(medium,) = spinel["media"].values()
(sun,) = spinel["lights"]

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
cycles = scene.cycles
cycles.device = "CPU"
cycles.samples, cycles.seed = int(spp), int(seed)
cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_auto_tile = False
cycles.max_bounces = cycles.volume_bounces = spinel["integrator"]["max_bounces"]
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0
cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
cycles.volume_max_steps = 1024
render = scene.render
render.resolution_x, render.resolution_y = spinel["film"]["size"]
render.resolution_percentage = 100
render.threads_mode, render.threads = "FIXED", 1
render.image_settings.file_format = "OPEN_EXR"
render.image_settings.color_depth = "32"
render.filepath = output


def place(thing, name):
    placed = bpy.data.objects.new(name, thing)
    scene.collection.objects.link(placed)
    return placed


# The volume in world space, density times σs and σa.
data = bpy.data.volumes.new("volume")
data.filepath = str((pathlib.Path(path).parent / volume["file"]).resolve())
data.render.space, data.render.step_size = "WORLD", 0.0
place(data, "volume")
material = bpy.data.materials.new("volume")
material.use_nodes = True
material.cycles.volume_sampling = "MULTIPLE_IMPORTANCE"
material.cycles.volume_interpolation = "LINEAR"
tree = material.node_tree
tree.nodes.clear()
info = tree.nodes.new("ShaderNodeVolumeInfo")
both = tree.nodes.new("ShaderNodeAddShader")
for i, (kind, color, coefficient) in enumerate((("Scatter", 1, medium["scattering"]),
                                                ("Absorption", 0, medium["absorption"]))):
    product = tree.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    product.inputs[1].default_value = coefficient
    tree.links.new(info.outputs["Density"], product.inputs[0])
    shader = tree.nodes.new("ShaderNodeVolume" + kind)
    shader.inputs["Color"].default_value = (color, color, color, 1)
    if kind == "Scatter":
        shader.inputs["Anisotropy"].default_value = medium["g"]
    tree.links.new(product.outputs[0], shader.inputs["Density"])
    tree.links.new(shader.outputs[0], both.inputs[i])
out = tree.nodes.new("ShaderNodeOutputMaterial")
tree.links.new(both.outputs[0], out.inputs["Volume"])
data.materials.append(material)

lamp = bpy.data.lights.new("sun", "SUN")
lamp.energy, lamp.angle = sun["irradiance"], 0.0
placed = place(lamp, "sun")
placed.rotation_mode = "QUATERNION"
placed.rotation_quaternion = (-Vector(sun["direction"])).to_track_quat("Z", "Y")
world = bpy.data.worlds.new("sky")
world.use_nodes = True
background = world.node_tree.nodes["Background"].inputs
background[0].default_value = (*[spinel["environment"]["radiance"]] * 3, 1)
background[1].default_value = 1
scene.world = world

camera = bpy.data.cameras.new("camera")
camera.sensor_fit, camera.angle, camera.clip_start = "VERTICAL", math.radians(spinel["camera"]["fov"]), 0.01
eye = Vector(spinel["camera"]["from"])
z = (eye - Vector(spinel["camera"]["at"])).normalized()
x = Vector((0, 1, 0)).cross(z).normalized()
scene.camera = place(camera, "camera")
scene.camera.matrix_world = Matrix([(*row, e) for row, e in zip(zip(x, z.cross(x), z), eye)] + [(0, 0, 0, 1)])

before = resource.getrusage(resource.RUSAGE_SELF)
bpy.ops.render.render(write_still=True)
after = resource.getrusage(resource.RUSAGE_SELF)
print(f"cpu_seconds={after.ru_utime - before.ru_utime:.3f}")
