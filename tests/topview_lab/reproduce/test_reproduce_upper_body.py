from __future__ import annotations

from pathlib import Path

import numpy as np

from skeleton_sequences import people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES
from topview_lab.evaluate.run import Outcome
from topview_lab.metrics import measure_sequence
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.runs import Measured, Run
from topview_lab.reproduce.upper_body import BESIDE, TORSO_METHODS, table_5_2

HANDS = [JOINT_NAMES.index(f"{side}_hand") for side in ("left", "right")]


def test_both_trackers_stand_side_by_side_part_by_part():
    context = Context(Path("nowhere"))
    first = context.own_sequences()[0]
    true = people_standing(4, 0.0)
    told = true.copy()
    told[:, :, HANDS[0], 0] += 0.03
    told[:, :, HANDS[1], 0] += 0.20
    hidden = np.zeros(true.shape[:3])
    hidden[:, :, HANDS[1]] = 1.0
    nothing = np.zeros_like(hidden)
    reference = reference_of(
        true, occluded_by_person=hidden, occluded_by_object=nothing, occluded_by_self=nothing,
        outside=nothing,
    )  # fmt: skip
    errors = measure_sequence(predicted_of(told), reference, first.name, seconds=0.2)
    outcome = Outcome(errors, ())
    measured = Measured({Run(method, first): outcome for method in TORSO_METHODS.values()})
    table = table_5_2(context, measured).tables[1]
    assert len(table.rows) == len(BESIDE) * len(context.own_sequences())
    name, *cells = table.rows[0].cells
    assert first.name in name
    assert cells == ["0.0", "–", "3.0", "20.0", "0.0", "–", "50"]
    assert set(table.rows[-1].cells[1:]) == {"–"}  # what was not measured
