"""The median against NumPy's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from topview.kernels.medians import median


@pytest.mark.parametrize("width", [32, 64])
@settings(deadline=None)
@given(data=st.data())
def test_it_is_numpys_bit_by_bit(width, data):
    dtype = np.dtype(f"f{width // 8}")
    number = st.floats(-1e6, 1e6, width=width)
    # Few different numbers, so that many are equal, or any.
    numbers = st.one_of(number, st.sampled_from([0.0, 0.5, 1.0, 2.0]))
    values = data.draw(arrays(dtype, st.integers(1, 40), elements=numbers))
    before = values.copy()
    assert median(values) == float(np.median(before))
    assert sorted(values) == sorted(before)
