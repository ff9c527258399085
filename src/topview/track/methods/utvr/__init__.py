"""The thesis's own tracker: part by part from the head down, a particle filter each (Sec. 5.3).

`UtvrTracker.update` is the whole recipe; `topview.track.methods.topview` is what this project makes
of it. `AS_PRINTED` is the recipe without what we add to it; docs/method.md says what that is, and
what each addition brings.
"""

from topview.track.methods.utvr.settings import AS_PRINTED, UtvrSettings
from topview.track.methods.utvr.tracker import UtvrTracker

__all__ = ["AS_PRINTED", "UtvrSettings", "UtvrTracker"]
