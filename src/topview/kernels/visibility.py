"""What the depth image shows round each of a body's joints, and along its parts."""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.body import place_parts

ALONG = 4  # places on a part's axis that are looked at; ours
STATES = 5  # those of `topview.records.JointState` but for absent, in that order


@njit(cache=True, nogil=True)
def look_round_joints(
    joints_camera, radii_m, circle, depth_m, labels, person, intrinsics, in_front_m, confirms_m,
    out_state, out_confirmed,
):  # fmt: skip
    """Count the places round each joint by what the image shows there.

    Args:
        joints_camera: [J, 3] metres; NaN of absent ones.
        radii_m: [J] from a joint to the surface before it.
        circle: [S, 2] places to the right and down, in radii.
        depth_m: [H, W] metres, 0 without a reading.
        labels: [H, W] id of the person that each pixel belongs to, 0 for nobody.
        person: id.
        intrinsics: fx, fy, cx and cy of the image.
        in_front_m: what is nearer than the surface by more than the first hides it; of the person,
            by more than the second.
        confirms_m: what is seen of the person within this confirms it.
        out_state: [J] becomes 0 of absent joints, otherwise 1 + the commonest of `STATES`.
        out_confirmed: [J] becomes the share of the places that confirm the joint.
    """
    fx, fy, cx, cy = intrinsics
    others_in_front_m, own_in_front_m = in_front_m
    height, width = depth_m.shape
    counts = np.empty(STATES, np.int64)
    for j in range(len(joints_camera)):
        x, y, z = joints_camera[j]
        counts[:] = 0
        confirming = 0
        for right, down in circle:
            column = np.rint(fx * (x + right * radii_m[j]) / z + cx) if z > 0.0 else -1.0
            row = np.rint(fy * (y + down * radii_m[j]) / z + cy) if z > 0.0 else -1.0
            if not (0.0 <= column < width and 0.0 <= row < height):
                counts[4] += 1
                continue
            seen_m, owner = depth_m[int(row), int(column)], labels[int(row), int(column)]
            surface_m = z - radii_m[j]
            before_m = own_in_front_m if owner == person else others_in_front_m
            if seen_m > 0.0 and seen_m < surface_m - before_m:
                counts[1 if owner == person else 2 if owner > 0 else 3] += 1
            else:
                counts[0] += 1
            if seen_m > 0.0 and abs(seen_m - surface_m) < confirms_m and owner == person:
                confirming += 1
        is_there = np.isfinite(x) and np.isfinite(y) and np.isfinite(z)
        out_state[j] = 1 + np.argmax(counts) if is_there else 0
        out_confirmed[j] = confirming / len(circle)


@njit(cache=True, error_model="numpy", nogil=True)
def look_along_parts(
    neck_camera, Rs, lengths_m, joints_parent, parents, radii_m, depth_m, mine, intrinsics,
    nearest_m, in_front_m, out,
):  # fmt: skip
    """Fill `out` [B] with the share of places on each part's axis that are outside of the image, or
    behind something that is not the person.

    Args:
        neck_camera, Rs: [3] metres and [B, 3, 3] of a pose.
        lengths_m, joints_parent, parents: [B], [B, 3] and [B] of its body.
        radii_m: [B, 2] of the parts; what lies before the thinner one's surface hides a place.
        depth_m, mine: [H, W] metres, 0 without a reading, and which pixels are the person's.
        intrinsics: fx, fy, cx and cy of the image.
        nearest_m: what is nearer to the camera is taken to be there.
        in_front_m: what is nearer than the surface by more than this hides it.
    """
    fx, fy, cx, cy = intrinsics
    height, width = depth_m.shape
    B = Rs.shape[0]
    origins = np.empty((B, 3))
    place_parts(neck_camera, Rs, lengths_m, joints_parent, parents, origins)
    for k in range(B):
        unseen = 0
        for place in range(ALONG):
            along_m = (place + 0.5) / ALONG * lengths_m[k]
            z = max(origins[k, 2] + along_m * Rs[k, 2, 1], nearest_m)
            column = np.rint(fx * (origins[k, 0] + along_m * Rs[k, 0, 1]) / z + cx)
            row = np.rint(fy * (origins[k, 1] + along_m * Rs[k, 1, 1]) / z + cy)
            if not (0.0 <= column < width and 0.0 <= row < height):
                unseen += 1
            elif not mine[int(row), int(column)]:
                seen_m, radius_m = depth_m[int(row), int(column)], min(radii_m[k, 0], radii_m[k, 1])
                unseen += seen_m > 0.0 and seen_m < z - radius_m - in_front_m
        out[k] = unseen / ALONG
