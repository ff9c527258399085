"""The documents, and the commands in them."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCUMENTS = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "src/topview*/**/*.md")
    for path in ROOT.glob(pattern)
)
# Commands in blocks of code, as `topview track my_recording --out results    # a comment`.
BLOCK = re.compile(r"^```\n(.*?)^```", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(
    r"^(?:topview|\./run) ((?!test|.*\.\.\.|.*\[)[a-z].*?)(?: +#.*)?$", re.MULTILINE
)
COMMANDS = sorted(
    {
        (document.name, command)
        for document in DOCUMENTS
        for block in BLOCK.findall(document.read_text().replace("\\\n", " "))
        for command in COMMAND.findall(block)
    }
)
