"""Prints where the rig of the rendered people has its joints, seen from the simulator's.

The network has seen rendered people only, so what it says of simulated ones in plain view, in
postures that it knows, tells how the two place their joints apart. The table goes into
`topview_lab/training/joints/simulated.py`.

    python scripts/fit_joint_centres.py
"""

from __future__ import annotations

from collections import defaultdict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView
from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.network import JointNetwork
from topview.detect.joints.windows import cut_windows
from topview_lab.sim.bodies import SIM_JOINT_NAMES
from topview_lab.sim.recording import SimulatedFrame, SimulatedRecording
from topview_lab.sim.scenes import scene_by_name
from topview_lab.training.joints.recordings import our_joint_name
from topview_lab.training.joints.simulated import CENTRE_PARTS, sim_part, stem_and_side

SCENES: Final = {"all_actions": range(3000, 3008), "turning": range(3010, 3014)}
EVERY: Final = 7
"""Frames."""
MOST_HIDDEN: Final = 0.3


def main() -> None:
    network = JointNetwork()
    ways: dict[str, list[NDArray[np.float64]]] = defaultdict(list)
    for name, seeds in SCENES.items():
        for seed in seeds:
            recording = SimulatedRecording(scene_by_name(name, seed=seed))
            stature_m = recording.scene.actors[0].body.appearance.stature_m
            for index in range(0, recording.frame_count, EVERY):
                _add_ways(ways, network, recording, recording.simulate(index), stature_m)
    for stem, part in CENTRE_PARTS.items():
        found = np.array(ways[stem])
        way = np.median(found, axis=0)
        spread = np.median(np.abs(found - way), axis=0)
        print(f'    "{stem}": ({way[0]:.3f}, {way[1]:.3f}, {way[2]:.3f}),', end="")
        print(f"  # along {part}; half are within {spread.round(3).tolist()}, {len(found)} seen")


def _add_ways(
    ways: dict[str, list[NDArray[np.float64]]],
    network: JointNetwork,
    recording: SimulatedRecording,
    frame: SimulatedFrame,
    stature_m: float,
) -> None:
    camera, truth = recording.camera, frame.truth
    view = DepthView(
        frame.depth_mm.astype(np.float32) / 1000.0, camera.fx, camera.fy, camera.cx, camera.cy
    )
    proposals = network.propose(cut_windows(view, frame.mask.astype(np.int32), [1]))
    proposed = proposals.positions_camera[0, int(np.argmax(proposals.weights[0]))]
    hidden = truth.joint_hidden
    shares = hidden.by.sum(-1) + hidden.by_furniture + hidden.by_self + hidden.outside
    for j, name in enumerate(SIM_JOINT_NAMES):
        if shares[0, j] > MOST_HIDDEN:
            continue
        stem, side = stem_and_side(name)
        R_camera_part = truth.Ts_camera_part[0, sim_part(stem, side), :3, :3]
        away = proposed[PROPOSED_JOINTS.index(our_joint_name(name))] - truth.joints[0, j]
        way = R_camera_part.T @ away / stature_m
        ways[stem].append(way * [-1.0 if side == "_l" else 0.0 if not side else 1.0, 1.0, 1.0])


if __name__ == "__main__":
    main()
