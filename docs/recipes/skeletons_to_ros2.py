"""Skeletons as a ROS 2 bag: a `geometry_msgs/PoseArray` of the joints for each person.

    pip install 'topview[ros]'
    python docs/recipes/skeletons_to_ros2.py results/skeletons.npz bag
    ros2 bag play bag        # /person_1/joints, ... in the frame "camera_depth_optical_frame"

ROS's optical frames have the axes of topview's camera frame. Joints that are not known are left
out; their order is that of `joint_names`.
"""

import sys
from pathlib import Path

import numpy as np

import topview

FRAME_ID = "camera_depth_optical_frame"


def main(path: str, out: str) -> int:
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    people = topview.read_skeletons(path)
    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = {name.rpartition("/")[2]: kind for name, kind in store.types.items()}
    written = 0
    with Writer(Path(out), version=8) as bag:
        for person in people.people_ids.tolist():
            topic = bag.add_connection(
                f"/person_{person}/joints", kinds["PoseArray"].__msgtype__, typestore=store
            )
            for row, slot in zip(*people.slots_of(person), strict=True):
                stamp_ns = round(float(people.timestamps_s[row]) * 1e9)
                stamp = kinds["Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
                turn = kinds["Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
                poses = [
                    kinds["Pose"](position=kinds["Point"](x=x, y=y, z=z), orientation=turn)
                    for x, y, z in people.joints_camera[row, slot].tolist()
                    if np.isfinite([x, y, z]).all()
                ]
                header = kinds["Header"](stamp=stamp, frame_id=FRAME_ID)
                message = kinds["PoseArray"](header=header, poses=poses)
                bag.write(topic, stamp_ns, store.serialize_cdr(message, message.__msgtype__))
                written += 1
    print(f"{written} messages written to {out}")
    return written


if __name__ == "__main__":
    main(*sys.argv[1:])
