"""The commands, methods and proposals of the laboratory: the only place of `topview` that names it.

Nothing is imported here. Each of them is imported when it is asked for, so that what only
measures, simulates or compares costs a user of `topview track` nothing.
"""

from __future__ import annotations

from typing import Final

# Name of each command: where it is, and its one sentence in `topview --help`.
COMMANDS: Final[dict[str, tuple[str, str]]] = {
    "demo": (
        "topview_lab.cli.demo:demo",
        "Simulate two people, track them, and compare the result with the truth.",
    ),
    "simulate": (
        "topview_lab.cli.simulate:simulate",
        "Write a simulated scene as a recording, with its truth.",
    ),
    "evaluate": (
        "topview_lab.cli.evaluate:evaluate",
        "Measure the tracker, or another system, against reference skeletons.",
    ),
    "reproduce": (
        "topview_lab.cli.reproduce:reproduce",
        "Make the thesis's figures and tables again, as one page.",
    ),
    "bench": ("topview_lab.cli.bench:bench", "Measure the tracker's speed on this machine."),
    "annotate": (
        "topview_lab.cli.annotate:annotate",
        "Make truth from colour markers in two recordings.",
    ),
    "train-skin": (
        "topview_lab.cli.train_skin:train_skin",
        "Learn what skin looks like from images with labelled masks.",
    ),
    "train-hands": (
        "topview_lab.cli.train_hands:train_hands",
        "Learn what faces and hands look like from labelled recordings.",
    ),
    "train-forest": (
        "topview_lab.cli.train_forest:train_forest",
        "Learn what body parts look like in depth images from the simulator.",
    ),
    "train-poses": (
        "topview_lab.cli.train_poses:train_poses",
        "Make the table of poses that whole bodies are looked up in.",
    ),
    "train-joints": (
        "topview_lab.cli.train_joints:train_joints",
        "Learn to propose joints from recordings with truth.",
    ),
    "train-people": (
        "topview_lab.cli.train_people:train_people",
        "Learn to tell people from furniture from recordings with truth.",
    ),
    "train-bias": (
        "topview_lab.cli.train_bias:train_bias",
        "Learn how far off found poses are, from recordings with truth.",
    ),
    "train-unseen-limbs": (
        "topview_lab.cli.train_unseen_limbs:train_unseen_limbs",
        "Learn where limbs are that are out of sight, from captured motion.",
    ),
    "train-confidence": (
        "topview_lab.cli.train_confidence:train_confidence",
        "Learn how far joints are off, from recordings with truth.",
    ),
}

# Name of each method to compare with: what makes it, called without arguments, and a sentence about
# it.
RIVAL_METHODS: Final[dict[str, tuple[str, str]]] = {
    "bpso": (
        "topview_lab.rivals.swarm:SwarmSettings",
        "a particle swarm over the whole body (Oikonomidis et al. 2011)",
    ),
    "ppso": (
        "topview_lab.rivals.swarm:perturbed_swarm",
        "the same, perturbed where it stagnates (Michel et al. 2015)",
    ),
    "forest": (
        "topview_lab.rivals.forest.tracker:ForestSettings",
        "body parts by a decision forest (Shotton et al. 2011), each frame by itself",
    ),
    "ellipsoids": (
        "topview_lab.rivals.ellipsoids:EllipsoidSettings",
        "ellipsoids fitted to the silhouette's points (Sec. 2.2): the upper body alone",
    ),
}

# Name of what proposes joints to compare with, the same.
RIVAL_PROPOSERS: Final[dict[str, tuple[str, str]]] = {
    "forest": (
        "topview_lab.rivals.forest.proposer:ForestProposer",
        "the joints for which a decision forest votes, one mode",
    ),
}
