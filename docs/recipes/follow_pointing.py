"""Where on the floor does somebody point? For a robot that goes there.

    topview track realsense: --out results --stream websocket:8765      # in one terminal
    python docs/recipes/follow_pointing.py ws://127.0.0.1:8765/         # in another

Prints the place in the camera frame, metres, each time somebody points with a straight arm.
The floor is given by hand here: how high the camera is, and that it is level.
"""

import json
import sys

import numpy as np

CAMERA_HEIGHT_M = 1.2
STRAIGHT = 0.97  # cosine between upper arm and forearm
DOWN_CAMERA = np.array([0.0, 1.0, 0.0])


def target(joints: dict, side: str) -> np.ndarray | None:
    """[3] where the line from shoulder to hand meets the floor; None if the arm is not straight,
    is not sure, or does not point down."""
    names = [f"{side}_{joint}" for joint in ("shoulder", "elbow", "hand")]
    if any(None in joints[name]["camera_m"] for name in names):
        return None
    if min(joints[name]["confidence"] for name in names) < 0.5:
        return None
    shoulder, elbow, hand = (np.array(joints[name]["camera_m"]) for name in names)
    upper, fore, way = elbow - shoulder, hand - elbow, hand - shoulder
    if upper @ fore < STRAIGHT * np.linalg.norm(upper) * np.linalg.norm(fore):
        return None
    fall = way @ DOWN_CAMERA
    is_raised = fall < 0.8 * np.linalg.norm(way)  # arms that hang point at nothing
    if fall <= 0.0 or not is_raised:
        return None
    return shoulder + way * (CAMERA_HEIGHT_M - shoulder @ DOWN_CAMERA) / fall


def main(address: str) -> None:
    from websockets.sync.client import connect

    with connect(address) as stream:
        for message in stream:
            for person in json.loads(message)["people"]:
                for side in ("left", "right"):
                    place = target(person["joints"], side)
                    if place is not None:
                        print(f"person {person['id']} points at {np.round(place, 2).tolist()}")


if __name__ == "__main__":
    main(*sys.argv[1:])
