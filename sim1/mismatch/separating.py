"""Recordings that tell two effects apart; what to vary for one of them, whatever imitates it, its own file says."""

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
