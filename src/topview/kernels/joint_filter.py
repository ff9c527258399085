"""A Kalman filter for each proposed joint: its place and velocity along three axes."""

from __future__ import annotations

from numba import njit

POSITION, VELOCITY, VARIANCE, COVARIANCE, OF_VELOCITY = range(5)


@njit(cache=True, error_model="numpy", nogil=True)
def filter_joints(places, scales, elapsed, unrest, most_surprise, state, out):
    """Filter the joints of one frame; each is measured as shares of its depth to the right and
    down, and in depth.

    Args:
        places, scales: [M, J, 3] metres, as in `topview.detect.joints.JointProposals`.
        elapsed: seconds since the frame before, their square and their cube.
        unrest: how fast the variance of a velocity grows, m2/s3.
        most_surprise: the sum of squared deviations, in variances, beyond which a joint starts
            anew.
        state: [5, M, J, 3] place, velocity, variance of the place, its covariance with the velocity
            and the velocity's variance, in the units of what is measured; goes on in place.
        out: [M, J, 3] becomes the filtered places in metres.
    """
    t, t2, t3 = elapsed
    for m in range(places.shape[0]):
        for j in range(places.shape[1]):
            surprise = 0.0
            for i in range(3):
                place, velocity, variance, covariance, of_velocity = state[:, m, j, i]
                to_metres = places[m, j, 2] if i < 2 else 1.0
                grows = unrest / (to_metres * to_metres)
                state[POSITION, m, j, i] = place + t * velocity
                state[VARIANCE, m, j, i] = (
                    variance + 2.0 * t * covariance + t2 * of_velocity + grows * t3 / 3.0
                )
                state[COVARIANCE, m, j, i] = covariance + t * of_velocity + grows * t2 / 2.0
                state[OF_VELOCITY, m, j, i] = of_velocity + grows * t
                off = places[m, j, i] / to_metres - state[POSITION, m, j, i]
                scale = scales[m, j, i] / to_metres
                surprise += off * off / (state[VARIANCE, m, j, i] + 2.0 * (scale * scale))
            for i in range(3):
                place, velocity, variance, covariance, of_velocity = state[:, m, j, i]
                to_metres = places[m, j, 2] if i < 2 else 1.0
                measured = places[m, j, i] / to_metres
                scale = scales[m, j, i] / to_metres
                noise = 2.0 * (scale * scale)  # the variance of a Laplace law
                if surprise > most_surprise:
                    state[POSITION, m, j, i] = measured
                    state[VELOCITY, m, j, i] = state[COVARIANCE, m, j, i] = 0.0
                    state[VARIANCE, m, j, i] = noise
                    state[OF_VELOCITY, m, j, i] = unrest / (to_metres * to_metres)
                    continue
                off = measured - place
                gain, velocity_gain = variance / (variance + noise), covariance / (variance + noise)
                state[POSITION, m, j, i] = place + gain * off
                state[VELOCITY, m, j, i] = velocity + velocity_gain * off
                state[VARIANCE, m, j, i] = (1.0 - gain) * variance
                state[COVARIANCE, m, j, i] = (1.0 - gain) * covariance
                state[OF_VELOCITY, m, j, i] = of_velocity - velocity_gain * covariance
            depth = state[POSITION, m, j, 2]
            out[m, j, 0] = state[POSITION, m, j, 0] * depth
            out[m, j, 1] = state[POSITION, m, j, 1] * depth
            out[m, j, 2] = depth
