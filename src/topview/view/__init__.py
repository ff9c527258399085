"""Pictures and a video of what was tracked."""

from topview.view.contact_sheet import ContactSheet
from topview.view.part_maps import PartMaps
from topview.view.people_sheet import PeopleSheet
from topview.view.video import OverlayVideo
from topview.view.viewer import Sheet, Viewer, Viewers

__all__ = ["ContactSheet", "OverlayVideo", "PartMaps", "PeopleSheet", "Sheet", "Viewer", "Viewers"]
