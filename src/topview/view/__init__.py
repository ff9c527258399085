"""Pictures of what was tracked."""

from topview.view.contact_sheet import ContactSheet
from topview.view.viewer import NullViewer, Viewer

__all__ = ["ContactSheet", "NullViewer", "Viewer"]
