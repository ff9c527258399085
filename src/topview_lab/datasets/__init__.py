"""Data sets that the tracker is measured on: one file each.

A data set yields `EvaluatedRecording`s: small, picklable descriptions that a worker process opens.
"""

from topview_lab.datasets.base import (
    EvaluatedRecording,
    KnowsReference,
    check_same_frames,
    select_by_name,
)
from topview_lab.datasets.berkeley_mhad import BerkeleyMhadSequence, find_berkeley_mhad
from topview_lab.datasets.folder import FolderRecording, find_folder_recordings
from topview_lab.datasets.groundtruth import read_groundtruth, reference_from
from topview_lab.datasets.itop import ItopSequence, find_itop
from topview_lab.datasets.msr_action3d import MsrAction3dSequence, find_msr_action3d
from topview_lab.datasets.simulated import SimulatedScene, make_simulated
from topview_lab.datasets.starts import SimulatedStart, make_starts
from topview_lab.datasets.utd_mhad import UtdMhadRecording, find_utd_mhad

__all__ = [
    "BerkeleyMhadSequence",
    "EvaluatedRecording",
    "FolderRecording",
    "ItopSequence",
    "KnowsReference",
    "MsrAction3dSequence",
    "SimulatedScene",
    "SimulatedStart",
    "UtdMhadRecording",
    "check_same_frames",
    "find_berkeley_mhad",
    "find_folder_recordings",
    "find_itop",
    "find_msr_action3d",
    "find_utd_mhad",
    "make_simulated",
    "make_starts",
    "read_groundtruth",
    "reference_from",
    "select_by_name",
]
