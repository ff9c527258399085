"""Count how often each person raises a hand above the shoulder and lowers it again.

    python docs/recipes/count_repetitions.py results/skeletons.npz left_hand left_shoulder

Other exercises are other joints: squats are the pelvis against the knees.
"""

import sys

import numpy as np

import topview

HIGH_M, LOW_M = 0.05, -0.10  # above the other joint, and below it: between them nothing is counted


def repetitions(heights_m: np.ndarray) -> int:
    """How often [N] heights rise above HIGH_M and fall below LOW_M again."""
    count, is_up = 0, False
    for height_m in heights_m[np.isfinite(heights_m)]:
        if not is_up and height_m > HIGH_M:
            is_up = True
        elif is_up and height_m < LOW_M:
            count, is_up = count + 1, False
    return count


def main(path: str, joint: str = "left_hand", other: str = "left_shoulder") -> dict[int, int]:
    people = topview.read_skeletons(path)
    known = np.isfinite(people.floor_camera).all()
    up_camera = people.floor_camera[:3] if known else np.array([0.0, -1.0, 0.0])  # a level camera
    counts = {}
    for person in people.people_ids.tolist():
        joints = people.joints_camera[people.slots_of(person)]
        way = joints[:, people.joint_names.index(joint)]
        way = way - joints[:, people.joint_names.index(other)]
        counts[person] = repetitions(way @ up_camera)
        print(f"person {person}: {counts[person]} times")
    return counts


if __name__ == "__main__":
    main(*sys.argv[1:])
