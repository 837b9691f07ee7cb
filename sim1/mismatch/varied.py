"""What to vary in a motion so that an effect shows otherwise than what imitates it."""

SEPARATING = {  # the recording that tells two explanations apart
    frozenset(
        ("air_drag", "added_mass")
    ): "swing at two amplitudes with the same period: drag grows with the square of the speed, carried air with the acceleration",
    frozenset(
        ("air_drag", "wind")
    ): "hang the cloth still, then turn the rig by 90 degrees: a stream pushes at rest too",
    frozenset(
        ("clock_offset", "actuator_lag")
    ): "stop suddenly and let the cloth swing free for 2 s: an offset shifts the free swing, a lag does not",
    frozenset(("grip_slip", "grip_compliance")): "pull and let go: what slipped does not come back",
    frozenset(
        ("frame_offset", "gravity_tilt")
    ): "turn the rig by 180 degrees about the vertical at rest: a tilt turns with the room, an offset with the camera",
    frozenset(
        ("stiff_region", "heavy_region")
    ): "swing slowly and fast: weight shows at rest, stiffness where the cloth folds",
}
VARIED = {  # by effect, where no recording is known that tells just these two apart
    "air_drag": "twice as fast (drag grows with the square of the speed)",
    "wind": "the rig turned by 90 degrees about the vertical (a stream keeps its direction in the room)",
    "added_mass": "shorter and quicker strokes of the same speed (carried air answers to the acceleration)",
    "anisotropic_stretch": "pulled taut, held by the neighbouring edge (the pull then runs along the other threads)",
    "anisotropic_bending": "held by the neighbouring edge (folds then run along the other threads)",
    "strain_stiffening": "pulled half as hard and twice as hard (strain then no longer follows the load)",
    "bending_hysteresis": "at half the pace (friction in the yarns loses the same in every cycle, however slow)",
    "plastic_crease": "once more after the cloth was laid flat and smoothed (a fold line stays)",
    "rest_curvature": "the cloth turned over (it then leans to the other side)",
    "shrinkage": "the cloth hung still beside a ruler (lengths are off by one share, loaded or not)",
    "stiff_region": "held by the opposite edge, at two speeds (a stiff place goes with the cloth, and shows where it folds)",
    "heavy_region": "held by the opposite edge, at rest too (a weight goes with the cloth, and hangs lower)",
    "static_friction": "with stops on the way (it sticks anew at every start)",
    "anisotropic_friction": "along the table's other axis (friction goes with the table, not with the threads)",
    "adhesion": "lifted slowly, without sliding (what clings lifts late)",
    "grip_slip": "a longer pull, and 1 s of rest in the first pose after it (what slipped does not come back)",
    "grip_compliance": "a harder pull, and 1 s of rest in the first pose after it (what gave way comes back)",
    "actuator_lag": "a sudden stop and 2 s of free swing (a lag shows while the robot moves, and not after)",
    "clock_offset": "a sudden stop and 2 s of free swing (an offset shifts the free swing too)",
    "frame_offset": "the rig turned by 180 degrees about the vertical (an offset goes with the camera)",
    "gravity_tilt": "the rig turned by 180 degrees about the vertical (a tilt goes with the room)",
}
TESTING = {  # a name that physics outside of the table was taken for, and the recording that would show it
    "gravity_tilt": "hang a plumb line beside the rig: a tilt pulls it, too, a static charge or a magnet does not",
    "heavy_region": "weigh the cloth, and film the same motion again an hour later: water dries, a weight stays",
    "plastic_crease": "lay the cloth flat, and film the same motion again an hour later: a crease stays, creep comes back",
    "wind": "film the same motion with the rig half a metre aside: a stream is the same there, a jet is not",
}
