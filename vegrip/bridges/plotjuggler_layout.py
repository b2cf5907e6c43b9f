"""A layout for PlotJuggler: the plots of the layout for Foxglove, by the paths of its reader of CDR."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence

from vegrip.bridges.foxglove_layout import COLOURS, PLOTS
from vegrip.transport.codec.schema import Topics


def plotjuggler_layout(hands: Mapping[str, Sequence[str]]) -> str:
    """Return what PlotJuggler loads; ``hands``: namespace, "" = none, -> fingers. One tab a finger."""
    root = ET.Element("root")
    tabs = ET.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    for namespace, fingers in hands.items():
        for finger in fingers:
            _tab(tabs, Topics(namespace), finger, f"{namespace} {finger}".strip())
    ET.SubElement(tabs, "currentTabIndex", index="0")
    ET.SubElement(root, "use_relative_time_offset", enabled="1")
    ET.indent(root, " ")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _tab(tabs: ET.Element, topics: Topics, finger: str, name: str) -> None:
    container = ET.SubElement(ET.SubElement(tabs, "Tab", containers="1", tab_name=name), "Container")
    sizes = ";".join(f"{1.0 / len(PLOTS):.3f}" for _ in PLOTS)
    split = ET.SubElement(container, "DockSplitter", orientation="-", count=str(len(PLOTS)), sizes=sizes)
    for title, series in PLOTS.values():
        plot = ET.SubElement(
            ET.SubElement(split, "DockArea", name=title), "plot", style="Lines", mode="TimeSeries"
        )
        ET.SubElement(plot, "limitY")
        for number, (kind, column, _) in enumerate(series):
            if (route := topics.outgoing(kind, finger)) is not None:
                ET.SubElement(plot, "curve", name=f"{route.topic}/{column}", color=COLOURS[number])
