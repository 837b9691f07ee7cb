"""How Blender turns the scene into a picture: Cycles, which follows light, or Workbench, which shows shapes and colours at once.

Imported by the worker alone: bpy lives in processes of its own.
"""

from typing import Any

import bpy  # noqa: TID253  only the worker's process gets here

from sim1.render.job import VIEW_TRANSFORM

PREVIEW_STOPS = 1.0  # by which Workbench's studio light is too dim


def set_up_engine(scene: bpy.types.Scene, settings: dict[str, Any]) -> str:
    """Choose the engine and set size, file format, tone curve and quality; what it renders on: "cpu", "gpu" or "opengl".

    Args:
        scene: Blender's scene.
        settings: engine, width, height, samples, denoise, device, and threads on a CPU, at least one.

    Raises:
        RuntimeError: the device is "gpu", and there is none.
    """
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = settings["width"], settings["height"], 100
    render.threads_mode, render.threads = "FIXED", settings["threads"]
    render.use_file_extension = False
    image = render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.compression = "PNG", "RGB", "8", 50
    for name in [name for name in dir(render) if name.startswith("use_stamp")]:
        setattr(render, name, False)  # dates and host names would end up in the PNG file
    view = scene.view_settings
    view.view_transform, view.look = VIEW_TRANSFORM[settings["engine"]], "None"
    view.exposure, view.gamma = 0.0, 1.0
    if settings["engine"] == "cycles":
        _set_up_cycles(scene, settings)
        return scene.cycles.device.lower()
    _set_up_workbench(scene)
    return "opengl"


def _set_up_cycles(scene: bpy.types.Scene, settings: dict[str, Any]) -> None:
    scene.render.engine = "CYCLES"
    scene.render.use_persistent_data = True  # keeps what did not change between frames
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling = settings["samples"], False
    cycles.use_denoising, cycles.denoiser = settings["denoise"], "OPENIMAGEDENOISE"
    cycles.max_bounces, cycles.glossy_bounces = 4, 2
    cycles.diffuse_bounces = 1  # the sky holds the light that walls and ceiling send on
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.sample_clamp_indirect = 5.0  # few samples: no fireflies
    cycles.device = _choose_device(settings["device"])
    if cycles.device == "GPU":
        scene.render.threads_mode = "AUTO"  # the one worker there, as a rule, prepares scenes alone


def _set_up_workbench(scene: bpy.types.Scene) -> None:
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.view_settings.exposure = PREVIEW_STOPS
    scene.display.render_aa = "8"
    shading = scene.display.shading
    shading.light, shading.color_type = "STUDIO", "TEXTURE"
    shading.show_shadows = shading.show_specular_highlight = False  # its lamp hangs at the camera
    shading.show_cavity, shading.cavity_type = True, "BOTH"  # darker creases in place of shadows


def _choose_device(wanted: str) -> str:
    """GPU where one is wanted or, with "auto", found; "cpu" never looks."""
    if wanted == "cpu":
        return "CPU"
    preferences = bpy.context.preferences.addons["cycles"].preferences
    for backend in ("OPTIX", "CUDA", "HIP", "ONEAPI", "METAL"):
        try:
            preferences.compute_device_type = backend
        except TypeError:
            continue  # this build of Blender does not know it
        preferences.get_devices()
        devices = [device for device in preferences.devices if device.type == backend]
        if devices:
            for device in preferences.devices:
                device.use = device.type == backend
            return "GPU"
    if wanted == "gpu":
        raise RuntimeError("device is 'gpu', and Cycles finds none; set it to 'auto' or 'cpu'")
    return "CPU"
